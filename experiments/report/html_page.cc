#include <fmt/format.h>

#include "experiments/report/mapper_pairs.h"
#include "experiments/report/report.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 -apple-system,'Segoe UI',Helvetica,Arial,sans-serif;color:#222;max-width:1180px;"
    "margin:32px auto;padding:0 20px}h1{font-size:26px;margin-bottom:4px}h2{font-size:19px;margin-top:36px;"
    "border-bottom:1px solid #ddd;padding-bottom:4px}table{border-collapse:collapse;font-size:13px;"
    "font-variant-numeric:tabular-nums}th,td{padding:5px 9px;text-align:right;white-space:nowrap}"
    "th{border-bottom:2px solid #333;font-weight:600}td{border-bottom:1px solid #eee}"
    ".l{text-align:left}.thesis td{color:#777;font-style:italic}.wide{overflow-x:auto}"
    ".plots{display:flex;flex-wrap:wrap;gap:16px}.plots svg{max-width:100%;height:auto;border:1px solid #eee}"
    ".note{color:#a33}.terms{color:#555;font-size:13px;margin:4px "
    "0}footer{margin-top:40px;color:#777;font-size:12px}";

std::string HtmlTable(const TextTable& table) {
  const auto cell = [&](const char* tag, const std::string& text, size_t column) {
    const bool left = column < table.left.size() && table.left[column];
    return fmt::format("<{0}{1}>{2}</{0}>", tag, left ? " class=\"l\"" : "", EscapeXml(text));
  };
  std::string html = "<div class=\"wide\"><table>\n<tr>";
  for (size_t i = 0; i < table.heading.size(); ++i) html += cell("th", table.heading[i], i);
  html += "</tr>\n";
  for (const auto& row : table.rows) {
    html += !row.empty() && row[0].starts_with("  thesis") ? "<tr class=\"thesis\">" : "<tr>";
    for (size_t i = 0; i < row.size(); ++i) html += cell("td", row[i], i);
    html += "</tr>\n";
  }
  html += "</table></div>\n";
  for (const std::string& note : table.notes) html += "<p class=\"terms\">" + EscapeXml(note) + "</p>\n";
  return html;
}

}  // namespace

std::string HtmlPage(const GroupedRuns& runs, const std::vector<std::string>& skipped) {
  const std::vector<std::string> objects = ObjectsOf(runs.groups);
  size_t count = 0;
  for (const RunGroup& group : runs.groups) count += group.runs.size();
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>SE-Atlas report</title>"
      "<style>{}</style></head><body>\n<h1>SE-Atlas report</h1>\n<p>{} runs of {} objects in {} "
      "configurations.</p>\n",
      kStyle, count, objects.size(), runs.groups.size());
  for (const std::string& line : skipped) html += "<p class=\"note\">left out: " + EscapeXml(line) + "</p>\n";
  html += "<h2>Means over seeds</h2>\n" + HtmlTable(GroupTable(runs));
  const TextTable pairs = MapperPairsTable(runs.groups);
  if (!pairs.rows.empty()) html += "<h2>Two mappers, same seeds</h2>\n" + HtmlTable(pairs);
  for (const std::string& object : objects) {
    html += "<h2>" + EscapeXml(object) + "</h2>\n<div class=\"plots\">\n" +
            CoverageByScanPlot(object, runs.groups) + CoverageByTimePlot(object, runs.groups) + "</div>\n";
  }
  return html + "<h2>Every run</h2>\n" + HtmlTable(RunsTable(runs)) + "</body></html>\n";
}

}  // namespace atlas::experiments
