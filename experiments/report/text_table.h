// Cells of text as aligned columns, Markdown, CSV or LaTeX.
#pragma once

#include <string>
#include <vector>

namespace atlas::experiments {

/// Cells of text under a heading. Columns flagged `left` are aligned left, the others right.
struct TextTable {
  std::vector<std::string> heading;
  std::vector<bool> left;
  std::vector<std::vector<std::string>> rows;
  std::vector<size_t> rules_before;     ///< a line is drawn before these rows
  std::vector<std::string> notes = {};  ///< lines under the table; CSV leaves them out
};

/// Aligned columns; display width counts UTF-8 characters, not bytes. Notes are broken at the table's width.
std::string ToTerminal(const TextTable& table);
std::string ToMarkdown(const TextTable& table);
std::string ToCsv(const TextTable& table);
/// A booktabs tabular, special characters escaped.
std::string ToLatex(const TextTable& table);

}  // namespace atlas::experiments
