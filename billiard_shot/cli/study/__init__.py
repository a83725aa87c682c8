"""`billiard-shot study STUDY`: what the method costs, how exact it is, and what it reproduces."""
