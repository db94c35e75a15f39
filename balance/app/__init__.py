"""Commands and their answers: as text, HTML and JSON."""
