"""The verbs of the command line: their options, what they do, and their answers in words."""
