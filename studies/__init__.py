"""Evidence for the documentation: methods and laws compared, hard cases, published values."""
