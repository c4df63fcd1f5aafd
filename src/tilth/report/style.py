# SPDX-License-Identifier: BSD-3-Clause
"""The style sheet inside ``report.html``."""

CSS = """
body { font: 15px/1.5 system-ui, "Segoe UI", "Liberation Sans", sans-serif; color: #222;
  background: #f4f3ef; margin: 0; }
main { max-width: 1040px; margin: 0 auto; padding: 1.5rem 2rem 2rem; background: #fff; }
h1 { font-size: 1.7rem; margin: 0.3rem 0 0.8rem; }
h2 { font-size: 1.2rem; margin: 2rem 0 0.7rem; padding-bottom: 0.2rem;
  border-bottom: 2px solid #c9a66b; }
h3 { font-size: 1rem; margin: 1.1rem 0 0.3rem; }
table { border-collapse: collapse; margin: 0.3rem 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 0.15rem 1.2rem 0.15rem 0; vertical-align: top;
  border-bottom: 1px solid #eee; }
th { font-weight: 600; color: #555; }
td { overflow-wrap: anywhere; }
.state { padding: 0.5rem 0.8rem; border-left: 4px solid; }
.good { background: #eef6ee; border-color: #2a6f4e; }
.bad { background: #fdf0e6; border-color: #c1121f; }
.warnings li { color: #9a4a00; }
code { background: #f4f3ef; padding: 0 0.2rem; }
footer { max-width: 1040px; margin: 0 auto; padding: 0.6rem 2rem; color: #888; font-size: 0.85rem; }
@media print {
  @page { margin: 15mm; }
  body { background: #fff; font-size: 10pt; } main { max-width: none; padding: 0; }
  h1, h2, h3 { break-after: avoid; } h2 { margin-top: 1.4rem; }
  li, .state { break-inside: avoid; } footer { padding: 0; }
  table { font-size: 8.5pt; } th, td { padding-right: 0.8rem; min-width: 5em; }
  .state { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
"""
