// Text that others wrote: shown without effect on a terminal, refused where it becomes a value or a name.
//
// Control characters here are C0 (below U+0020, line ends and tabs among them), DEL and C1 (U+0080 to U+009F,
// as UTF-8 or as single bytes): what terminals act on and what ends a line of a script.
#pragma once

#include <string>
#include <string_view>

namespace atlas::core {

/// `text` as a terminal may show it: control characters and bytes that are no UTF-8 as \n, \t, \r or \xHH.
std::string Printable(std::string_view text);

/// `text` as one cell of a CSV table (RFC 4180): in quotes where it holds a comma, a quote or a line end.
std::string CsvCell(const std::string& text);

bool HasControlCharacters(std::string_view text);

/// @throws InputError "WHAT: holds a control character: 'a\nb'".
void RefuseControlCharacters(std::string_view text, const std::string& what);

/// `text` as one component of a path: letters, digits, '.', '-' and '_', every other byte a '-'; at most 80
/// long, never empty, and beginning with neither '.' nor '-'. Where that changed anything, eight hexadecimal
/// digits of a hash follow, so that different texts keep different names.
std::string FileNameFrom(std::string_view text);

/// `word` on one line, so that bash reads it back unchanged; without control characters, any POSIX shell.
std::string ShellQuoted(const std::string& word);

}  // namespace atlas::core
