"""Classes of change, one file for each; `change_kind.py` has their base."""
