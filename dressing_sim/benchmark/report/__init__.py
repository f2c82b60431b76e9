"""What episodes leave behind: ``summary.json``, ``report.md``, ``report.html``."""

from dressing_sim.benchmark.report.cards import Picture
from dressing_sim.benchmark.report.summary import summarise
from dressing_sim.benchmark.report.text import markdown_table, paper_cells, table
from dressing_sim.benchmark.report.write import write_report

__all__ = ["Picture", "markdown_table", "paper_cells", "summarise", "table", "write_report"]
