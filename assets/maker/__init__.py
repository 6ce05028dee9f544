"""The makers of the bundled assets; see ../make.py."""
