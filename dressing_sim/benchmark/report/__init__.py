"""Reports: a `Document` and its writers to a terminal, Markdown and HTML; one style of plots."""
