#include "core/named_files.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/files.h"
#include "core/fingerprint.h"
#include "core/params.h"

namespace atlas::core {
namespace {
namespace fs = std::filesystem;

TEST(FileBeside, FilesAreRelativeToTheNamingFilesFolderAndNamesAreNames) {
  EXPECT_EQ(FileBeside("mine", "scene.yaml"), "mine/scene.yaml");
  EXPECT_EQ(FileBeside("mine/exp", "../scenes/a.yaml"), "mine/scenes/a.yaml");
  EXPECT_EQ(FileBeside("mine", "robot.xml"), "mine/robot.xml");
  EXPECT_EQ(FileBeside("mine", "/data/scene.yaml"), "/data/scene.yaml");
  EXPECT_EQ(FileBeside("", "scene.yaml"), "scene.yaml");
  for (const char* name : {"helicopter", "0.05", "occlusion_aware", "vlp16"}) {
    EXPECT_EQ(FileBeside("mine", name), name);
  }
}

TEST(CopyNames, KeepTheFilesNamesAndNeverShareOne) {
  EXPECT_EQ(CopyNames({"a/x.obj", "b/y.obj", "b/x.obj", "a/x.obj"}),
            (std::vector<fs::path>{"x.obj", "y.obj", "2/x.obj", "x.obj"}));
}

TEST(Fingerprint, PiecesAreKeptApart) {
  const auto of = [](std::string_view a, std::string_view b) {
    Fingerprint print;
    print.Text(a);
    print.Text(b);
    return print.Hex();
  };
  EXPECT_EQ(of("ab", "c"), of("ab", "c"));
  EXPECT_NE(of("ab", "c"), of("a", "bc"));
  EXPECT_NE(of("ab", ""), of("", "ab"));
  EXPECT_EQ(of("ab", "c").size(), 16u);
}

struct Inner {
  std::string name = "car";
  void Visit(ParamVisitor& v) { v.Field("name", &name, {.is_file = true}); }
};
struct Outer {
  Inner scene;
  std::string word = "x";
  void Visit(ParamVisitor& v) {
    v.Section("scene", &scene);
    v.Field("word", &word, {});
  }
};

class FilesInYaml : public ::testing::Test {
 protected:
  FilesInYaml() { fs::remove_all(root_); }
  ~FilesInYaml() override { fs::remove_all(root_); }
  void Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(root_ / name, text);
  }
  Outer Load(const std::string& name, const std::vector<std::string>& assignments = {}) const {
    ParamSource source;
    source.MergeFile(root_ / name, root_);
    for (const std::string& assignment : assignments) source.MergeAssignment(assignment);
    Outer outer;
    source.Load(&outer);
    return outer;
  }
  const fs::path root_ = fs::temp_directory_path() / "atlas_files_in_yaml";
};

TEST_F(FilesInYaml, AreRelativeToTheFileThatNamesThem) {
  Write("a/one.yaml", "scene: s.yaml\nword: w.yaml\n");
  EXPECT_EQ(Load("a/one.yaml").scene.name, (root_ / "a/s.yaml").string());
  EXPECT_EQ(Load("a/one.yaml").word, "w.yaml");  // not declared as a file
  Write("a/two.yaml", "scene: {name: ../s.yaml}\n");
  EXPECT_EQ(Load("a/two.yaml").scene.name, (root_ / "s.yaml").string());
}

TEST_F(FilesInYaml, KeepTheirMeaningWhenAFileOfAnotherFolderExtendsTheirs) {
  Write("a/base.yaml", "scene: s.yaml\n");
  Write("b/more.yaml", "extends: ../a/base.yaml\nword: y\n");
  EXPECT_EQ(Load("b/more.yaml").scene.name, (root_ / "a/s.yaml").string());
  Write("b/name.yaml", "extends: ../a/base\n");
  EXPECT_EQ(Load("b/name.yaml").scene.name, (root_ / "a/s.yaml").string());
}

TEST_F(FilesInYaml, OfTheCommandLineAreRelativeToTheWorkingDirectory) {
  Write("a/one.yaml", "scene: s.yaml\n");
  EXPECT_EQ(Load("a/one.yaml", {"scene=t.yaml"}).scene.name, "t.yaml");
  EXPECT_EQ(Load("a/one.yaml", {"scene.name=u/t.yaml"}).scene.name, "u/t.yaml");
  EXPECT_EQ(Load("a/one.yaml", {"scene=car"}).scene.name, "car");
}

}  // namespace
}  // namespace atlas::core
