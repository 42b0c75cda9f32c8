#include "core/safe_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "core/errors.h"

namespace atlas::core {
namespace {

constexpr size_t kLongestName = 80;

/// Length of the valid UTF-8 sequence that `text` begins with (RFC 3629), or 0.
size_t SequenceLength(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const size_t length = lead >= 0xf0 && lead <= 0xf4   ? 4
                        : lead >= 0xe0 && lead <= 0xef ? 3
                        : lead >= 0xc2 && lead <= 0xdf ? 2
                                                       : 0;
  if (length == 0 || text.size() < length) return 0;
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
  const bool no_character = (lead == 0xed && byte(1) > 0x9f) || (lead == 0xf4 && byte(1) > 0x8f);
  return overlong || no_character ? 0 : length;
}

/// Whether the sequence of `length` bytes at the front is a control character; 0: a byte that is no UTF-8.
bool IsControl(std::string_view text, size_t length) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (length == 0) return lead >= 0x80 && lead <= 0x9f;
  if (length == 1) return lead < 0x20 || lead == 0x7f;
  return lead == 0xc2 && static_cast<unsigned char>(text[1]) <= 0x9f;
}

std::string Escaped(std::string_view bytes) {
  if (bytes == "\n") return "\\n";
  if (bytes == "\t") return "\\t";
  if (bytes == "\r") return "\\r";
  std::string text;
  for (const char c : bytes) text += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  return text;
}

uint32_t HashOf(std::string_view text) {  // FNV-1a
  uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

}  // namespace

std::string Printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const size_t length = SequenceLength(text);
    const std::string_view bytes = text.substr(0, std::max<size_t>(length, 1));
    shown += length == 0 || IsControl(text, length) ? Escaped(bytes) : std::string(bytes);
    text.remove_prefix(bytes.size());
  }
  return shown;
}

std::string CsvCell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

bool HasControlCharacters(std::string_view text) {
  while (!text.empty()) {
    const size_t length = SequenceLength(text);
    if (IsControl(text, length)) return true;
    text.remove_prefix(std::max<size_t>(length, 1));
  }
  return false;
}

void RefuseControlCharacters(std::string_view text, const std::string& what) {
  if (!HasControlCharacters(text)) return;
  throw InputError(fmt::format("{}: holds a control character: '{}'", what, Printable(text)));
}

std::string FileNameFrom(std::string_view text) {
  std::string name(text.substr(0, kLongestName));
  for (char& c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '-' || c == '_';
    if (!plain) c = '-';
  }
  if (name.empty() || name[0] == '.' || name[0] == '-') name = fmt::format("_{}", name);
  return name == text ? name : fmt::format("{}-{:08x}", name, HashOf(text));
}

std::string ShellQuoted(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                          "0123456789_-./=:,+%@") == std::string::npos;
  if (plain) return word;
  const bool one_line = !HasControlCharacters(word);
  std::string quoted = one_line ? "'" : "$'";  // of bash: \x0a for a line end, so that a line stays one
  for (const char c : word) {
    if (one_line) {
      quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    } else if (c >= ' ' && c <= '~' && c != '\'' && c != '\\') {
      quoted += c;
    } else {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return quoted + "'";
}

}  // namespace atlas::core
