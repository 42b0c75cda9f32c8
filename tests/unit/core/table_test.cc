#include "core/table.h"

#include <gtest/gtest.h>

namespace atlas::core {
namespace {

TEST(Table, CellsAreWrittenByTheirColumns) {
  const std::vector<Column> columns = {
      {"scan", "", ""}, {"distance_m", "m", "", 2}, {"gain", "", "", 3, Column::Format::kSignificant},
      {"flat", "", ""}, {"word", "", ""},           {"absent", "", ""}};
  Row row;
  row.Set("word", "a, b");
  row.Set("distance_m", 1.005);
  row.Set("gain", 123456.0);
  row.Set("scan", 7);
  row.Set("flat", true);
  row.Set("of no column", 1.0);
  row.Set("absent", std::optional<double>());
  EXPECT_EQ(CsvHeader(columns), "scan,distance_m,gain,flat,word,absent\n");
  EXPECT_EQ(CsvLine(columns, row), "7,1.00,1.23e+05,1,\"a, b\",\n");
  row.Set("scan", 8);
  EXPECT_EQ(row.Number("scan"), 8.0);
  EXPECT_EQ(row.Number("flat"), 1.0);
  EXPECT_FALSE(row.Number("word") || row.Number("absent") || row.Number("never"));
  EXPECT_EQ(row.cells().front().first, "word") << "the order in which they were first set";
}

}  // namespace
}  // namespace atlas::core
