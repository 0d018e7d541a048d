"""Watching matches, live and from logs, and what can be said of them: ``cprm-gym watch``, ``convert``, ``stats``."""
