#include "core/table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/safe_text.h"

namespace atlas::core {

void Row::Set(const std::string& column, Cell cell) {
  const auto known =
      std::find_if(cells_.begin(), cells_.end(), [&](const auto& entry) { return entry.first == column; });
  if (known == cells_.end()) {
    cells_.emplace_back(column, std::move(cell));
  } else {
    known->second = std::move(cell);
  }
}

const Cell& Row::At(const std::string& column) const {
  static const Cell kNothing;
  for (const auto& [name, cell] : cells_) {
    if (name == column) return cell;
  }
  return kNothing;
}

std::optional<double> Row::Number(const std::string& column) const {
  const Cell& cell = At(column);
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  if (const auto* count = std::get_if<int64_t>(&cell)) return static_cast<double>(*count);
  if (const auto* flag = std::get_if<bool>(&cell)) return *flag ? 1.0 : 0.0;
  return std::nullopt;
}

std::string TextOf(const Column& column, const Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) {
    return column.format == Column::Format::kFixed ? fmt::format("{:.{}f}", *number, column.digits)
                                                   : fmt::format("{:.{}g}", *number, column.digits);
  }
  if (const auto* count = std::get_if<int64_t>(&cell)) return fmt::format("{}", *count);
  if (const auto* flag = std::get_if<bool>(&cell)) return *flag ? "1" : "0";
  if (const auto* text = std::get_if<std::string>(&cell)) return CsvCell(*text);
  return "";
}

std::string CsvHeader(const std::vector<Column>& columns) {
  std::string line;
  for (const Column& column : columns) line += (line.empty() ? "" : ",") + column.name;
  return line + "\n";
}

std::string CsvLine(const std::vector<Column>& columns, const Row& row) {
  std::string line;
  for (size_t i = 0; i < columns.size(); ++i) {
    line += (i > 0 ? "," : "") + TextOf(columns[i], row.At(columns[i].name));
  }
  return line + "\n";
}

}  // namespace atlas::core
