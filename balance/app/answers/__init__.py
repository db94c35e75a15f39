"""Answers to read: as text and as HTML."""
