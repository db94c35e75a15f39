"""Files of results that many processes compute, chunk by chunk, and one process writes."""
