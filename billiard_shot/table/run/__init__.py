"""A table from its beginning to rest: the event loop, batches, results."""
