// Text files row by row, with numbers that are checked.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace atlas::core {

/// The lines of a text, without their ends ("\n" or "\r\n").
class TextLines {
 public:
  explicit TextLines(std::string_view text) : text_(text) {}

  /// The next line, if any.
  std::optional<std::string_view> Next() {
    if (at_ >= text_.size()) return std::nullopt;
    const size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++number_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  size_t number() const { return number_; }  ///< of the last line, from 1
  size_t position() const { return at_; }    ///< first byte after the last line

 private:
  std::string_view text_;
  size_t at_ = 0;
  size_t number_ = 0;
};

/// The words of a line between blanks (space, tab) or any character of `also`.
inline std::vector<std::string_view> SplitWords(std::string_view line, std::string_view also = "") {
  std::vector<std::string_view> words;
  const auto is_blank = [&](char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || also.find(c) != std::string_view::npos;
  };
  for (size_t i = 0; i < line.size();) {
    while (i < line.size() && is_blank(line[i])) ++i;
    const size_t begin = i;
    while (i < line.size() && !is_blank(line[i])) ++i;
    if (i > begin) words.push_back(line.substr(begin, i - begin));
  }
  return words;
}

/// `word` as a number: all of it, or none. Reads nan and inf; a leading + is allowed.
template <typename T>
std::optional<T> ParseNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace atlas::core
