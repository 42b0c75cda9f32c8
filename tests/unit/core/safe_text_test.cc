#include "core/safe_text.h"

#include <gtest/gtest.h>

#include <set>

#include "core/errors.h"

namespace atlas::core {
namespace {

TEST(Printable, LeavesTextAsItIs) {
  for (const char* text : {"", "plain text", "± 0,5 µm — 温度 🤖", "a\\nb"}) {
    EXPECT_EQ(Printable(text), text);
    EXPECT_FALSE(HasControlCharacters(text));
  }
}

TEST(Printable, ShowsWhatATerminalWouldActOn) {
  EXPECT_EQ(Printable("\x1b[2Jgone"), "\\x1b[2Jgone");
  EXPECT_EQ(Printable("\x1b]0;title\a"), "\\x1b]0;title\\x07");
  EXPECT_EQ(Printable("a\nb\tc\rd\x7f"), "a\\nb\\tc\\rd\\x7f");
  EXPECT_EQ(Printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m");  // CSI of C1, as UTF-8
  EXPECT_EQ(Printable("\x9b"
                      "31m"),
            "\\x9b31m");  // and as one byte
  EXPECT_EQ(Printable(std::string_view("a\0b", 3)), "a\\x00b");
}

TEST(Printable, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(Printable("caf\xe9"), "caf\\xe9");     // Latin-1
  EXPECT_EQ(Printable("\xc0\x9b"), "\\xc0\\x9b");  // overlong ESC
  EXPECT_EQ(Printable("\xe0\x80\x9b"), "\\xe0\\x80\\x9b");
  EXPECT_EQ(Printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // half a surrogate pair
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(Printable("\xe2\x82"), "\\xe2\\x82");  // cut short
}

TEST(ControlCharacters, AreFoundInEveryEncoding) {
  for (int c = 0; c < 256; ++c) {
    std::string text = "a?b";
    text[1] = static_cast<char>(c);
    const bool control = c < 0x20 || (c >= 0x7f && c <= 0x9f);
    EXPECT_EQ(HasControlCharacters(text), control) << c;
  }
  EXPECT_TRUE(HasControlCharacters("\xc2\x85"));   // NEL
  EXPECT_FALSE(HasControlCharacters("\xc2\xa0"));  // no-break space
  EXPECT_FALSE(HasControlCharacters("\xe2\x82\x9b"));
}

TEST(ControlCharacters, AreRefusedByNameAndShown) {
  EXPECT_NO_THROW(RefuseControlCharacters("a b", "--out"));
  try {
    RefuseControlCharacters("a\nrm -rf b", "--out");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--out: holds a control character: 'a\\nrm -rf b'");
  }
}

TEST(InputError, NeverSendsWhatItQuotes) {
  EXPECT_STREQ(InputError("unknown key 'a\x1b[31m\nb' \n").what(), "unknown key 'a\\x1b[31m\\nb'");
}

TEST(CsvCell, IsQuotedWhereItWouldEndOrSplitTheRow) {
  EXPECT_EQ(CsvCell("rotor blade"), "rotor blade");
  EXPECT_EQ(CsvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvCell("a,b \"q\""), "\"a,b \"\"q\"\"\"");
}

TEST(FileName, KeepsPlainNames) {
  for (const char* name : {"helicopter", "facade_grass", "0.05", "a-b.c"})
    EXPECT_EQ(FileNameFrom(name), name);
}

TEST(FileName, IsOneHarmlessComponentAndAnotherForEachText) {
  const std::vector<std::string> texts = {"",
                                          ".",
                                          "..",
                                          "x/../../..",
                                          "/etc/passwd",
                                          "-rf",
                                          "a b",
                                          "a\nb",
                                          "a\tb",
                                          "a;b",
                                          "a$b",
                                          ".hidden",
                                          "a\\b",
                                          "Ä",
                                          "x/../../../",
                                          std::string("a\0b", 3),
                                          std::string(300, 'a'),
                                          std::string(301, 'a'),
                                          "con/aux"};
  std::set<std::string> names;
  for (const std::string& text : texts) {
    const std::string name = FileNameFrom(text);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(name.empty());
    EXPECT_LE(name.size(), 100u);
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-"),
              std::string::npos)
        << name;
    EXPECT_NE(name[0], '.');
    EXPECT_NE(name[0], '-');
  }
}

}  // namespace
}  // namespace atlas::core
