"""What records show before a wheel is fitted to them."""
