#include "core/params.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/files.h"

namespace atlas::core {
namespace {

namespace fs = std::filesystem;

struct InnerParams {
  std::string name = "plain";
  double size_m = 1.0;
  void Visit(ParamVisitor& v) {
    v.Field("name", &name, {.choices = {"plain", "fancy"}, .doc = "kind"});
    v.Field("size_m", &size_m, {.unit = "m", .min = 0.5, .max = 2.0, .doc = "edge"});
  }
};

struct OuterParams {
  int count = 3;
  bool active = false;
  std::vector<std::string> words;
  InnerParams inner;
  void Visit(ParamVisitor& v) {
    v.Field("count", &count, {.min = 1, .max = 9, .doc = "how many"});
    v.Field("active", &active, {.doc = "on"});
    v.Field("words", &words, {.doc = "some"});
    v.Section("inner", &inner);
  }
};

class ParamFiles : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(dir_); }
  void TearDown() override { fs::remove_all(dir_); }
  fs::path Write(const std::string& name, const std::string& text) {
    WriteFileAtomically(dir_ / name, text);
    return dir_ / name;
  }
  OuterParams Load(const std::string& text, const std::vector<std::string>& sets = {}) {
    ParamSource source;
    source.MergeFile(Write("a.yaml", text), dir_);
    for (const auto& s : sets) source.MergeAssignment(s);
    OuterParams params;
    rows_ = source.Load(&params);
    return params;
  }
  std::string Refusal(const std::string& text, const std::vector<std::string>& sets = {}) {
    try {
      Load(text, sets);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  fs::path dir_ = fs::temp_directory_path() / ("atlas_params_" + std::to_string(::getpid()));
  std::vector<ParamRow> rows_;
};

TEST_F(ParamFiles, LaterLayersWinAndOriginsAreKept) {
  Write("base.yaml", "count: 2\ninner: {size_m: 1.5}\n");
  const OuterParams params = Load("extends: base\ninner: fancy\n", {"count=5", "words=[x, y]"});
  EXPECT_EQ(params.count, 5);
  EXPECT_EQ(params.inner.name, "fancy");
  EXPECT_DOUBLE_EQ(params.inner.size_m, 1.5);
  EXPECT_EQ(params.words, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(rows_[0].origin, "--set count=5");
  EXPECT_NE(rows_[3].origin.find("a.yaml:2"), std::string::npos) << rows_[3].origin;
  EXPECT_EQ(rows_[1].origin, "default");
}

TEST_F(ParamFiles, BadInputNamesFileKeyValueAndLimit) {
  EXPECT_NE(Refusal("count: 12\n").find("a.yaml:1: count: 12 is out of range, must be [1, 9]"),
            std::string::npos);
  EXPECT_NE(Refusal("count: soon\n").find("expected a whole number, got 'soon'"), std::string::npos);
  EXPECT_NE(Refusal("count: 2.5\n").find("expected a whole number"), std::string::npos);
  EXPECT_NE(Refusal("inner: {size_m: .nan}\n").find("inner.size_m: expected a number"), std::string::npos);
  EXPECT_NE(Refusal("inner: {sise_m: 1}\n").find("did you mean 'inner.size_m'?"), std::string::npos);
  EXPECT_NE(Refusal("inner: fency\n").find("did you mean 'fancy'"), std::string::npos);
  EXPECT_NE(Refusal("active: maybe\n").find("expected true or false"), std::string::npos);
  EXPECT_NE(Refusal("count: {a: 1}\n").find("expected a whole number, got a section"), std::string::npos);
  EXPECT_NE(Refusal("inner: [1, 2]\n").find("a section, not a list"), std::string::npos);
  EXPECT_NE(Refusal("a: [1\nb").find("malformed YAML"), std::string::npos);
  EXPECT_NE(Refusal("extends: nowhere\n").find("extends 'nowhere'"), std::string::npos);
  EXPECT_NE(Refusal("extends: a\n").find("extends itself"), std::string::npos);
  EXPECT_NE(Refusal("count: 1\n", {"inner.size_m"}).find("expected section.key=value"), std::string::npos);
  EXPECT_NE(Refusal("count: 1\n", {"inner.size_m=7"}).find("--set inner.size_m=7: inner.size_m: 7"),
            std::string::npos);
}

TEST_F(ParamFiles, WhatIsAmbiguousOrEndlessIsRefusedByFileAndLine) {
  const std::string path = (dir_ / "a.yaml").string();
  EXPECT_EQ(Refusal("inner: &a {name: *a}\n"), path + ":1: an alias stands inside of what it names");
  EXPECT_EQ(Refusal("count: 1\ncount: 2\n"), path + ":2: the key 'count' stands twice (first in line 1)");
  EXPECT_EQ(Refusal("count: 1\n---\ncount: 2\n"), path + ":2: a second document (a file holds one)");
  EXPECT_EQ(Refusal("? [a, b]\n: 3\n"), path + ":1: a key must be plain text");
  EXPECT_EQ(Refusal("", {"inner={size_m: 1, size_m: 2}"}),
            "--set inner={size_m: 1, size_m: 2}:1: the key 'size_m' stands twice (first in line 1)");
  std::string deep = "a";
  for (int i = 0; i < 100000; ++i) deep += ".a";
  EXPECT_TRUE(Refusal("", {deep + "=1"}).ends_with(": nested deeper than 32 levels"));
}

TEST_F(ParamFiles, ExtendsIsOneNameAndEndsHoweverItIsSpelt) {
  const std::string path = (dir_ / "a.yaml").string();
  const std::string wanted = path + ":1: extends: expected the name of one file, got ";
  EXPECT_EQ(Refusal("extends: [a, b]\n"), wanted + "a list");
  EXPECT_EQ(Refusal("extends: {a: b}\n"), wanted + "a section");
  EXPECT_EQ(Refusal("extends:\n"), wanted + "''");
  Write("b.yaml", "extends: ././a\n");
  EXPECT_NE(Refusal("extends: ./b\n").find("extends itself through "), std::string::npos);
  fs::create_symlink(dir_ / "a.yaml", dir_ / "link.yaml");
  EXPECT_NE(Refusal("extends: link\n").find("extends itself through "), std::string::npos);
  const std::string longest = fmt::format("{:x>300}", "");
  EXPECT_NE(Refusal("extends: " + longest + "\n").find(path + ":1: extends '" + longest + "', but there is"),
            std::string::npos);
  for (int i = 1; i < 16; ++i) Write(fmt::format("c{}.yaml", i), fmt::format("extends: c{}\n", i - 1));
  Write("c0.yaml", "count: 4\n");
  EXPECT_EQ(Load("extends: c14\n").count, 4);
  EXPECT_EQ(Refusal("extends: c15\n"), path + ": extends a chain of more than 16 files");
}

TEST_F(ParamFiles, AnEmptyValueIsNoDefault) {
  EXPECT_EQ(Refusal("", {"inner="}), "--set inner=: the value is empty");
  EXPECT_EQ(Refusal("", {"words= "}), "--set words= : the value is empty");
  EXPECT_EQ(Refusal("", {"inner=~"}), "--set inner=~: the value is empty");
  EXPECT_EQ(Refusal("", {"inner=\"\""}), "--set inner=\"\": inner: expected a name or keys, got ''");
  EXPECT_TRUE(Load("words: [a]\n", {"words=[]"}).words.empty());
}

TEST_F(ParamFiles, ControlCharactersAreRefusedInValuesKeysAndAssignments) {
  const std::string path = (dir_ / "a.yaml").string();
  const std::string what = ": holds a control character: ";
  EXPECT_EQ(Refusal("count: 2\ninner: {name: \"pl\\nain\"}\n"), path + ":2" + what + "'pl\\nain'");
  EXPECT_EQ(Refusal("words: [a, \"b\\e[2J\"]\n"), path + ":1" + what + "'b\\x1b[2J'");
  EXPECT_EQ(Refusal("\"co\\tunt\": 2\n"), path + ":1" + what + "'co\\tunt'");
  EXPECT_EQ(Refusal("", {"inner.name=plain\ntouch x"}), "--set" + what + "'inner.name=plain\\ntouch x'");
  EXPECT_EQ(Refusal("", {"words=[\"a\\nb\"]"}), "--set:1" + what + "'a\\nb'");
}

TEST_F(ParamFiles, DumpLoadsBackToTheSameValues) {
  const OuterParams params =
      Load("count: 7\nactive: true\nwords: [a b, c]\ninner: {name: fancy, size_m: 0.625}\n");
  const std::string dump = DumpYaml(rows_);
  const OuterParams again = Load(dump);
  EXPECT_EQ(again.count, params.count);
  EXPECT_EQ(again.active, params.active);
  EXPECT_EQ(again.words, params.words);
  EXPECT_EQ(again.inner.name, params.inner.name);
  EXPECT_DOUBLE_EQ(again.inner.size_m, params.inner.size_m);
  EXPECT_EQ(DumpYaml(rows_), dump);
}

}  // namespace
}  // namespace atlas::core
