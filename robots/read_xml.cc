#include "robots/read_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/property_tree/xml_parser.hpp>
#include <sstream>
#include <string_view>

#include "core/errors.h"
#include "core/files.h"

namespace atlas::robots {
namespace {

/// The parser calls itself for every level, and so does what reads its tree.
constexpr int kDeepestElement = 256;
constexpr std::string_view kBlank = " \t\r\n";

/// Walks over a text's tags as the parser does, without recursion. What the parser might understand in
/// another way is refused as malformed.
class TagWalk {
 public:
  TagWalk(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// @throws InputError where elements are nested too deeply.
  void CheckDepth() {
    int depth = 0;
    while ((at_ = text_.find('<', at_)) < text_.size()) {
      if (Skip("<!--", "-->") || Skip("<![CDATA[", "]]>") || Skip("<?", "?>")) continue;
      if (Skip("</", ">")) {
        depth = std::max(depth - 1, 0);
      } else if (text_.substr(at_).starts_with("<!")) {
        Fail("malformed XML: neither a comment nor an element");
      } else if (!SkipStartTag() && ++depth > kDeepestElement) {
        Fail(fmt::format("elements are nested deeper than {} levels", kDeepestElement));
      }
    }
  }

 private:
  /// Where `begin` stands here: goes past the next `end`.
  bool Skip(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) return false;
    const size_t found = text_.find(end, at_ + begin.size());
    at_ = found < text_.size() ? found + end.size() : text_.size();
    return true;
  }

  /// Goes past "<name attribute='value' ...>"; true where it ends in "/>", which closes the element too.
  bool SkipStartTag() {
    at_ = std::min(text_.find_first_of(" \t\r\n/>=\"'<", at_ + 1), text_.size());
    char before = ' ';  // but for blanks
    while (at_ < text_.size() && text_[at_] != '>') {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        if (before != '=') Fail("malformed XML: a quote outside of an attribute's value");
        at_ = std::min(text_.find(c, at_ + 1), text_.size());
      } else if (c == '<' || (c == '=' && before == ' ')) {
        Fail(fmt::format("malformed XML: '{}' in a tag", c));
      }
      if (kBlank.find(c) == std::string_view::npos) before = c;
      at_ = std::min(at_ + 1, text_.size());
    }
    at_ = std::min(at_ + 1, text_.size());
    return before == '/';
  }

  [[noreturn]] void Fail(const std::string& what) const {
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
    throw core::InputError(fmt::format("{}:{}: {}", file_, std::count(text_.begin(), end, '\n') + 1, what));
  }

  std::string_view text_;
  std::string file_;
  size_t at_ = 0;
};

}  // namespace

boost::property_tree::ptree ReadXml(const std::filesystem::path& file) {
  const std::string text = core::ReadFile(file, 16u << 20);
  TagWalk(text, file.string()).CheckDepth();
  std::istringstream in(text);
  try {
    boost::property_tree::ptree tree;
    using namespace boost::property_tree::xml_parser;
    read_xml(in, tree, trim_whitespace | no_comments);
    return tree;
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw core::InputError(
        fmt::format("{}:{}: malformed XML: {}", file.string(), error.line(), error.message()));
  }
}

}  // namespace atlas::robots
