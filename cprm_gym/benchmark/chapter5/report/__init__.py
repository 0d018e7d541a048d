"""What is told of the suite: tables, small multiples and sentences; as JSON, Markdown and one page of HTML."""
