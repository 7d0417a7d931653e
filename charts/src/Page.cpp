#include "isofront/charts/Page.h"

#include "isofront/charts/SvgChart.h"

#include <string_view>

namespace isofront::charts {

namespace {

constexpr std::string_view kColours = R"css(
:root { color-scheme: light dark;
  --page: #f6f7f8; --card: #ffffff; --ink: #1b1f24; --faint: #5b6570; --line: #d9dee3;
  --a: #c2500a; --b: #187a4b; --c: #2563c9; --d: #8a3fb8;
  --e: #b3261e; --f: #007a87; --g: #7a6a00; --h: #5b6570; }
@media (prefers-color-scheme: dark) { :root {
  --page: #14171a; --card: #1d2125; --ink: #e8ebee; --faint: #9aa5b0; --line: #343b42;
  --a: #ff9d5c; --b: #4fc98d; --c: #74a9ff; --d: #cf95f2;
  --e: #ff8a80; --f: #4fd0de; --g: #d9c74a; --h: #9aa5b0; } }
)css";

constexpr std::string_view kChart = R"css(
text { font-size: 12px; fill: var(--faint); font-variant-numeric: tabular-nums; }
.grid { stroke: var(--line); stroke-width: 1; } .axis { stroke: var(--faint); stroke-width: 1; }
.curve { fill: none; stroke: var(--colour); stroke-width: 1.6; stroke-linejoin: round;
  stroke-linecap: round; }
.a { --colour: var(--a); } .b { --colour: var(--b); } .c { --colour: var(--c); } .d { --colour: var(--d); }
.e { --colour: var(--e); } .f { --colour: var(--f); } .g { --colour: var(--g); } .h { --colour: var(--h); }
.mark { fill: var(--colour); stroke: var(--card); stroke-width: 1; }
.guide { stroke: var(--faint); stroke-width: 1; stroke-dasharray: 3 4; fill: none; }
)css";

constexpr std::string_view kPage = R"css(
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 1000px; margin: 0 auto; padding: 24px 16px 48px; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 1.05rem; margin: 0 0 4px; }
p { margin: 0; } .what { color: var(--faint); margin-bottom: 20px; overflow-wrap: anywhere; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
  padding: 16px; margin-top: 16px; }
.tiles { display: grid; grid-template-columns: repeat(3, 1fr); gap: 12px; }
.tile { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 12px 14px; }
.tile b { display: block; font-size: 1.45rem; font-weight: 600; line-height: 1.2;
  font-variant-numeric: tabular-nums; white-space: nowrap; }
.tile span { color: var(--faint); font-size: .85rem; line-height: 1.35; display: block; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 18px; font-size: .85rem; color: var(--faint);
  margin-bottom: 10px; }
.legend i { display: inline-block; width: 18px; height: 3px; border-radius: 2px;
  vertical-align: middle; margin-right: 7px; background: var(--colour); }
video, img { display: block; width: 100%; height: auto; border-radius: 6px; margin-top: 8px; }
svg { display: block; width: 100%; height: auto; }
.narrow { display: none; }
@media (max-width: 640px) { .wide { display: none; } .narrow { display: block; }
  .tiles { grid-template-columns: 1fr 1fr; }
  .tile:last-child:nth-child(odd) { grid-column: 1 / -1; } section { padding: 12px; } }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .92rem; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 5px 0 5px 14px; border-top: 1px solid var(--line); }
thead th { border-top: 0; color: var(--faint); font-weight: 500; }
th:first-child, td:first-child { text-align: left; padding-left: 0; font-weight: 500; }
.settings th { font-weight: 400; color: var(--faint); vertical-align: top; width: 9.5em; }
.settings td { text-align: left; overflow-wrap: anywhere; }
)css";

} // namespace

std::string pageBegin(const std::string& title)
{
    return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           escaped(title) + "</title>\n<style>" + std::string(kColours) + std::string(kPage) +
           std::string(kChart) + "</style>\n</head>\n<body>\n<main>\n";
}

std::string pageEnd()
{
    return "</main>\n</body>\n</html>\n";
}

std::string chartStyle()
{
    return std::string(kColours) +
           "text { font-family: system-ui, -apple-system, \"Segoe UI\", Roboto, \"DejaVu Sans\", "
           "sans-serif; }" +
           std::string(kChart);
}

std::string curveStyle(unsigned number)
{
    return {static_cast<char>('a' + number % 8)};
}

} // namespace isofront::charts
