// YAML that could be understood in two ways, or that could exhaust the machine, is refused by file and line.
#include "core/yaml_text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/errors.h"

namespace atlas::core {
namespace {

std::string YamlRefusal(const std::string& text) {
  try {
    ParseYaml(text, "a.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string Repeated(const std::string& text, size_t times) {
  std::string all;
  for (size_t i = 0; i < times; ++i) all += text;
  return all;
}

TEST(YamlText, WhatIsSoundIsReadAsItStands) {
  const YAML::Node node = ParseYaml("---\na: &x {b: [1, 2]}\nc: *x\nd:\n...\n", "a.yaml");
  EXPECT_EQ(node["c"]["b"][1].Scalar(), "2");
  EXPECT_TRUE(node["d"].IsNull());
  EXPECT_TRUE(ParseYaml("", "a.yaml").IsNull());
  EXPECT_TRUE(ParseYaml("# nothing\n", "a.yaml").IsNull());
  EXPECT_EQ(YamlRefusal("a: {b: 1}\nc: {b: 2}\nd: [{b: 1}, {b: 2}]\n"), "");
}

TEST(YamlText, AnAliasInsideOfWhatItNamesIsRefused) {
  const std::string what = "an alias stands inside of what it names";
  EXPECT_EQ(YamlRefusal("planner: &a {terrain: *a}\n"), "a.yaml:1: " + what);
  EXPECT_EQ(YamlRefusal("x: 1\na: &a\n  - [*a]\n"), "a.yaml:3: " + what);
  EXPECT_NE(YamlRefusal("a: *b\n").find("a.yaml:1: malformed YAML"), std::string::npos);
}

TEST(YamlText, AliasesCountAsOftenAsTheyStand) {
  std::string text = "a0: &a0 [x, x]\n";
  for (int i = 1; i <= 24; ++i) text += fmt::format("a{}: &a{} [*a{}, *a{}]\n", i, i, i - 1, i - 1);
  EXPECT_EQ(YamlRefusal(text), "a.yaml:16: more than 200000 values and keys");
  EXPECT_EQ(YamlRefusal("a: [" + Repeated("0, ", kMostYamlNodes) + "0]\n"),
            "a.yaml:1: more than 200000 values and keys");
  EXPECT_EQ(YamlRefusal("a: [" + Repeated("0, ", kMostYamlNodes - 4) + "0]\n"), "");
}

TEST(YamlText, DepthIsBoundedThroughAliasesToo) {
  const auto nested = [](size_t levels) { return Repeated("[", levels) + Repeated("]", levels); };
  EXPECT_EQ(YamlRefusal(nested(kMostYamlDepth)), "");
  EXPECT_EQ(YamlRefusal(nested(kMostYamlDepth + 1)), "a.yaml:1: nested deeper than 32 levels");
  EXPECT_EQ(YamlRefusal(nested(100000)), "a.yaml:1: nested deeper than 32 levels");
  EXPECT_NE(YamlRefusal(Repeated("[", 100000)), "");
  const std::string half = "a: &a " + nested(20) + "\nb: ";
  EXPECT_EQ(YamlRefusal(half + "[[*a]]\n"), "");
  EXPECT_EQ(YamlRefusal(half + Repeated("[", 12) + "*a" + Repeated("]", 12) + "\n"),
            "a.yaml:2: nested deeper than 32 levels");
}

TEST(YamlText, AKeyIsPlainTextAndStandsOnce) {
  EXPECT_EQ(YamlRefusal("? [a, b]\n: 3\n"), "a.yaml:1: a key must be plain text");
  EXPECT_EQ(YamlRefusal("a: 1\n? {b: 1}\n: 3\n"), "a.yaml:2: a key must be plain text");
  EXPECT_EQ(YamlRefusal("a: {~: 3}\n"), "a.yaml:1: a key must be plain text");
  EXPECT_EQ(YamlRefusal("a: &x b\n*x : 3\n"), "a.yaml:2: a key must be plain text");
  EXPECT_EQ(YamlRefusal("a: 1\nb: 2\n\"a\": 3\n"), "a.yaml:3: the key 'a' stands twice (first in line 1)");
  EXPECT_EQ(YamlRefusal("a:\n  - {b: [1], c: 2, b: [1]}\n"),
            "a.yaml:2: the key 'b' stands twice (first in line 2)");
}

TEST(YamlText, AFileHoldsOneDocument) {
  EXPECT_EQ(YamlRefusal("a: 1\n---\nb: 2\n"), "a.yaml:2: a second document (a file holds one)");
  EXPECT_EQ(YamlRefusal("a: 1\n...\n---\n"), "a.yaml:3: a second document (a file holds one)");
}

TEST(YamlText, MalformedYamlIsToldByItsLine) {
  EXPECT_NE(YamlRefusal("a: 1\nb: [1\nc").find("a.yaml:3: malformed YAML: "), std::string::npos);
  EXPECT_NE(YamlRefusal("a: 'x").find("a.yaml:1: malformed YAML: "), std::string::npos);
  EXPECT_NE(YamlRefusal("a: \"\\q\"\n").find("a.yaml:1: malformed YAML: "), std::string::npos);
}

}  // namespace
}  // namespace atlas::core
