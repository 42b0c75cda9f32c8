#include "core/checked_folder.h"

#include <limits>
#include <vector>

#include "core/checksum.h"
#include "core/csv_table.h"

namespace atlas::core {

namespace fs = std::filesystem;

void CheckedFolderWriter::Text(const std::string& name, const std::string& content) {
  WriteFileAtomically(folder_ / name, content);
  Written(name);
}

void CheckedFolderWriter::Written(const std::string& name) {
  const std::string content = ReadFile(folder_ / name);
  list_ += fmt::format("{},{},{:016x}\n", name, content.size(), Crc64(content));
}

void CheckedFolderWriter::Finish(const IsOwnFile& is_own) const {
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (is_own(name) && name != "files.csv" && list_.find("\n" + name + ",") == std::string::npos)
      others.push_back(entry.path());
  }
  for (const fs::path& file : others) fs::remove(file);
  WriteFileAtomically(folder_ / "files.csv",
                      list_ + fmt::format("files.csv,{},{:016x}\n", list_.size(), Crc64(list_)));
}

void CheckFolder(const fs::path& folder, const IsOwnFile& is_own) {
  const fs::path list = folder / "files.csv";
  CsvTable table(list, "file,bytes,crc64");
  const std::string text = ReadFile(list);
  bool whole = false;
  while (table.NextRow()) {
    if (whole) table.Fail(fmt::format("line {}: after the end", table.line()));
    const std::string name(table.Word());
    const auto bytes = table.Number<uint64_t>(0, std::numeric_limits<int64_t>::max());
    const std::string crc(table.Word());
    whole = name == "files.csv";
    if (!whole && !is_own(name))
      table.Fail(fmt::format("line {}: no file of such a folder: {}", table.line(), name));
    const std::string content = whole ? text.substr(0, bytes) : ReadFile(folder / name);
    if (content.size() != bytes) {
      throw InputError(
          fmt::format("{}: damaged: {} bytes, must be {}", (folder / name).string(), content.size(), bytes));
    }
    if (const std::string found = fmt::format("{:016x}", Crc64(content)); found != crc) {
      throw InputError(
          fmt::format("{}: damaged: checksum {}, must be {}", (folder / name).string(), found, crc));
    }
  }
  if (!whole) table.Fail("ends early: its own checksum is missing");
}

}  // namespace atlas::core
