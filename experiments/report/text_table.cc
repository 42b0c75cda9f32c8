#include "experiments/report/text_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/safe_text.h"

namespace atlas::experiments {
namespace {

size_t DisplayWidth(const std::string& text) {
  return static_cast<size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

bool IsLeft(const TextTable& table, size_t column) {
  return column < table.left.size() && table.left[column];
}

std::string Padded(const std::string& text, size_t width, bool left) {
  const std::string space(width - std::min(width, DisplayWidth(text)), ' ');
  return left ? text + space : space + text;
}

std::string EscapeLatex(const std::string& text) {
  std::string safe;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '&' || c == '%' || c == '$' || c == '#' || c == '_' || c == '{' || c == '}') {
      safe += '\\';
      safe += c;
    } else if (c == '\\') {
      safe += "\\textbackslash{}";
    } else if (c == '~' || c == '^') {
      safe += fmt::format("\\{}{{}}", c);
    } else if (text.compare(i, 2, "±") == 0) {
      safe += "$\\pm$";
      ++i;
    } else {
      safe += c;
    }
  }
  return safe;
}

template <typename Escape>
std::string Join(const std::vector<std::string>& cells, const std::string& between, const Escape& escape) {
  std::string line;
  for (size_t i = 0; i < cells.size(); ++i) line += (i > 0 ? between : "") + escape(cells[i]);
  return line;
}

/// `text` in lines of at most `width` characters, broken at spaces.
std::string Wrapped(const std::string& text, size_t width) {
  std::string lines, line;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (!line.empty() && DisplayWidth(line) + 1 + DisplayWidth(word) > width) {
      lines += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return lines + line + "\n";
}

}  // namespace

std::string ToTerminal(const TextTable& table) {
  std::vector<size_t> width(table.heading.size(), 0);
  const auto widen = [&](const std::vector<std::string>& cells) {
    for (size_t i = 0; i < cells.size() && i < width.size(); ++i)
      width[i] = std::max(width[i], DisplayWidth(cells[i]));
  };
  widen(table.heading);
  for (const auto& row : table.rows) widen(row);
  const auto line_of = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (size_t i = 0; i < cells.size(); ++i)
      line += (i > 0 ? "  " : "") + Padded(cells[i], width[i], IsLeft(table, i));
    line.erase(line.find_last_not_of(' ') + 1);
    return line + "\n";
  };
  size_t total = width.empty() ? 0 : 2 * (width.size() - 1);
  for (const size_t w : width) total += w;
  std::string rule;
  for (size_t i = 0; i < total; ++i) rule += "─";
  rule += "\n";

  std::string text = line_of(table.heading) + rule;
  for (size_t r = 0; r < table.rows.size(); ++r) {
    if (r > 0 && std::count(table.rules_before.begin(), table.rules_before.end(), r) > 0) text += rule;
    text += line_of(table.rows[r]);
  }
  constexpr size_t kNarrowest = 80;
  for (const std::string& note : table.notes) text += Wrapped(note, std::max(total, kNarrowest));
  return text;
}

std::string ToMarkdown(const TextTable& table) {
  const auto escape = [](const std::string& cell) {
    std::string safe;
    for (const char c : cell) safe += c == '|' ? std::string("\\|") : std::string(1, c);
    return safe;
  };
  std::string text = "| " + Join(table.heading, " | ", escape) + " |\n|";
  for (size_t i = 0; i < table.heading.size(); ++i) text += IsLeft(table, i) ? "---|" : "---:|";
  text += "\n";
  for (const auto& row : table.rows) text += "| " + Join(row, " | ", escape) + " |\n";
  for (const std::string& note : table.notes) text += "\n" + note + "\n";
  return text;
}

std::string ToCsv(const TextTable& table) {
  std::string text = Join(table.heading, ",", core::CsvCell) + "\n";
  for (const auto& row : table.rows) text += Join(row, ",", core::CsvCell) + "\n";
  return text;
}

std::string ToLatex(const TextTable& table) {
  std::string text = "\\begin{tabular}{";
  for (size_t i = 0; i < table.heading.size(); ++i) text += IsLeft(table, i) ? 'l' : 'r';
  text += "}\n\\toprule\n" + Join(table.heading, " & ", EscapeLatex) + " \\\\\n\\midrule\n";
  for (size_t r = 0; r < table.rows.size(); ++r) {
    if (r > 0 && std::count(table.rules_before.begin(), table.rules_before.end(), r) > 0)
      text += "\\midrule\n";
    text += Join(table.rows[r], " & ", EscapeLatex) + " \\\\\n";
  }
  text += "\\bottomrule\n\\end{tabular}\n";
  for (const std::string& note : table.notes) {
    text += "\n{\\footnotesize " + EscapeLatex(note) + "\\par}\n";
  }
  return text;
}

}  // namespace atlas::experiments
