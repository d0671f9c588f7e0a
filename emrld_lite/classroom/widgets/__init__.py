"""Things that move on the page, one module per lesson; each has a still picture of what it shows."""
