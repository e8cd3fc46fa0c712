"""Dedicated bench methods: steady speeds, torque steps, coast-down."""
