"""Editing nets and models: documents with undo and redo, small JSON operations, checks in the background, files and drafts, no loss.

    page --operation--> Desk --> Document --> the JSON form of a net or model, built by the architecture after each operation
                              \\-> Files: written as a whole or not at all; drafts; a file that changed meanwhile is asked about

`net_operations` and `model_operations` list what can be done. Nothing in a file is executed.
"""
