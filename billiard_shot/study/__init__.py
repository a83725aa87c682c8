"""What accuracy and effects cost: tables and pictures."""
