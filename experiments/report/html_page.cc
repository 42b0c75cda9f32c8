#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "experiments/report/report.h"

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
    ".note{color:#a33}footer{margin-top:40px;color:#777;font-size:12px}";

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
  return html + "</table></div>\n";
}

}  // namespace

std::string HtmlPage(const std::vector<ReportedRun>& runs, const std::vector<std::string>& skipped) {
  std::vector<RunSummary> summaries;
  std::vector<std::string> experiments;
  std::set<std::string> versions;
  for (const ReportedRun& run : runs) {
    summaries.push_back(run.summary);
    if (std::count(experiments.begin(), experiments.end(), run.summary.experiment) == 0) {
      experiments.push_back(run.summary.experiment);
    }
    versions.insert(run.summary.version +
                    (run.summary.commit.empty() ? "" : " (" + run.summary.commit + ")"));
  }
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>SE-Atlas report</title>"
      "<style>{}</style></head><body>\n<h1>SE-Atlas report</h1>\n<p>{} runs of {} experiments.</p>\n",
      kStyle, runs.size(), experiments.size());
  for (const std::string& line : skipped) html += "<p class=\"note\">left out: " + EscapeXml(line) + "</p>\n";
  html += "<h2>Mean and spread over seeds</h2>\n" + HtmlTable(GroupTable(GroupRuns(summaries), true));
  html +=
      "<p>c_p: point cloud coverage (thesis Eq. 3.9, aligned). Attainable: the same score for the union of "
      "noise-free "
      "sweeps from all reachable poses. d_t: distance walked. n_s: scans. t_all: simulated time. t_nbv: wall "
      "time a "
      "decision. RTF: simulated over wall time. Spread: sample standard deviation.</p>\n";
  for (const std::string& experiment : experiments) {
    html += "<h2>" + EscapeXml(experiment) + "</h2>\n<div class=\"plots\">\n" +
            CoverageByScanPlot(experiment, runs) + CoverageByTimePlot(experiment, runs) + "</div>\n";
  }
  html += "<h2>Every run</h2>\n" + HtmlTable(RunsTable(summaries));
  html += "<footer>";
  for (const std::string& version : versions) html += "version " + EscapeXml(version) + " ";
  return html + "</footer>\n</body></html>\n";
}

}  // namespace atlas::experiments
