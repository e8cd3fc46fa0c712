"""Fleet of simulated flights with wheels that age: telemetry of years with known truth."""
