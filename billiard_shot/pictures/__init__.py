"""Pictures and pages of shots and studies."""
