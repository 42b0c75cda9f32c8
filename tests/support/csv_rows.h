// A comma-separated table with a header, read plainly: a map from column to cell for each row.
#pragma once

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/files.h"

namespace atlas::tests {

using CsvRow = std::map<std::string, std::string>;

inline std::vector<CsvRow> ReadCsvText(const std::string& text) {
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line) c == ',' ? cells.emplace_back() : cells.back() += std::string(1, c);
    return cells;
  };
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> header = cells_of(line);
  std::vector<CsvRow> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = cells_of(line);
    CsvRow row;
    for (size_t i = 0; i < header.size(); ++i) row[header[i]] = i < cells.size() ? cells[i] : "<missing>";
    rows.push_back(row);
  }
  return rows;
}

inline std::vector<CsvRow> ReadCsv(const std::filesystem::path& file) {
  return ReadCsvText(core::ReadFile(file));
}

}  // namespace atlas::tests
