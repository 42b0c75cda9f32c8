// Tables that runs write, a row at a time: whoever measures something declares its column once, with unit and
// meaning; files, lists of what there is, reports and plots follow from that.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace atlas::core {

/// How numbers of a column are written where no machine's speed may show: with fixed decimals or significant
/// digits. Counts and flags (0 or 1) have none.
struct Column {
  enum class Format { kFixed, kSignificant };
  std::string name;     ///< "coverage_outer"; its unit stands at its end, as in "sim_time_s"
  std::string unit;     ///< "" for shares in [0, 1], counts, flags and words
  std::string meaning;  ///< one line
  int digits = 6;
  Format format = Format::kFixed;
};

/// Nothing where it was not measured.
using Cell = std::variant<std::monostate, double, int64_t, bool, std::string>;

/// Cells by column, in the order in which they were first set.
class Row {
 public:
  void Set(const std::string& column, Cell cell);
  void Set(const std::string& column, double number) { Set(column, Cell(number)); }
  void Set(const std::string& column, int count) { Set(column, Cell(int64_t{count})); }
  void Set(const std::string& column, size_t count) { Set(column, Cell(static_cast<int64_t>(count))); }
  void Set(const std::string& column, bool flag) { Set(column, Cell(flag)); }
  void Set(const std::string& column, const char* text) { Set(column, Cell(std::string(text))); }
  template <typename Value>
  void Set(const std::string& column, const std::optional<Value>& value) {
    value ? Set(column, *value) : Set(column, Cell());
  }

  /// Nothing where the column was never set.
  const Cell& At(const std::string& column) const;
  /// The cell's number, count or flag (0 or 1); nothing where it holds none.
  std::optional<double> Number(const std::string& column) const;
  const std::vector<std::pair<std::string, Cell>>& cells() const { return cells_; }

 private:
  std::vector<std::pair<std::string, Cell>> cells_;
};

/// The same cell gives the same text on every machine.
std::string TextOf(const Column& column, const Cell& cell);
/// Lines end with a line feed.
std::string CsvHeader(const std::vector<Column>& columns);
/// Cells of columns that are not among `columns` are left out.
std::string CsvLine(const std::vector<Column>& columns, const Row& row);

}  // namespace atlas::core
