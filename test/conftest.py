"""What holds for all tests."""
from hypothesis import settings

# Whether a machine is busy says nothing about the code.
settings.register_profile('patient', deadline=None)
settings.load_profile('patient')
