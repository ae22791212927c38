"""Planning for many robots: who is in whose way and when, safe intervals, orders, repair."""
