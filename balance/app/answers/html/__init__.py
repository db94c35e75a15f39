"""Pages and pictures: HTML files that need no network, and figures."""
