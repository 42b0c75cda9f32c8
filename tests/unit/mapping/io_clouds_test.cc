// Files are put together here byte by byte; the writers are then judged by the readers.
#include <gtest/gtest.h>

#include <cstring>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"
#include "mapping/io/cloud_writer.h"
#include "mapping/io/lzf.h"
#include "mapping/io/recorded_cloud.h"
#include "tests/support/shared_data.h"

namespace atlas::mapping {
namespace {

using core::ReturnKind;
using core::Vec3f;

template <typename T>
void Put(std::string* out, T value, bool big = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));
  out->append(raw, sizeof(T));
}

std::string ErrorOf(const std::string& bytes, RecordedCloud (*parse)(std::string_view, const std::string&)) {
  try {
    parse(bytes, "some/file");
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PcdReader, AsciiGivesTheNumbersThatStandThere) {
  const RecordedCloud cloud = ParsePcd(
      "# a comment\nVERSION .7\nFIELDS intensity x y z label\nSIZE 4 4 4 4 1\nTYPE F F F F U\nCOUNT 1 1 1 1 "
      "2\n"
      "WIDTH 2\nHEIGHT 2\nVIEWPOINT 1 2 3 0 0 0 1\nPOINTS 4\nDATA ascii\n"
      "9 1 2 3 0 0\r\n9 nan nan nan 0 0\n\n9 0 0 0 0 0\n9 -1.5e0 +2 3 1 1\n",
      "a.pcd");
  EXPECT_TRUE(cloud.organised);
  EXPECT_EQ(cloud.rows, 2);
  EXPECT_EQ(cloud.columns, 2);
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_EQ(cloud.p_lidar[0], Vec3f(1, 2, 3));
  EXPECT_TRUE(std::isnan(cloud.p_lidar[1].x()));
  EXPECT_TRUE(std::isnan(cloud.p_lidar[2].x())) << "all zero is no return";
  EXPECT_EQ(cloud.p_lidar[3], Vec3f(-1.5, 2, 3));
  EXPECT_EQ(cloud.T_map_lidar.translation(), core::Vec3(1, 2, 3));
  EXPECT_NEAR(cloud.T_map_lidar.linear()(0, 0), -1.0, 1e-12) << "half a turn about z";
  EXPECT_TRUE(cloud.time_s.empty() && cloud.kind.empty() && cloud.ring.empty());
}

TEST(PcdReader, BinaryFieldsOfAnyOrderSizeAndType) {
  std::string bytes =
      "VERSION 0.7\nFIELDS t ring z _ x y kind\nSIZE 4 2 8 1 4 2 1\nTYPE U U F U F I U\nCOUNT 1 1 1 5 1 1 1\n"
      "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary\n";
  for (int i = 0; i < 2; ++i) {
    Put(&bytes, uint32_t{50'000'000} * static_cast<uint32_t>(i));
    Put(&bytes, static_cast<uint16_t>(7 + i));
    Put(&bytes, 1.25 * i);
    bytes.append(5, '\xff');
    Put(&bytes, 4.0f);
    Put(&bytes, static_cast<int16_t>(-3));
    Put(&bytes, static_cast<uint8_t>(2 * i));
  }
  const RecordedCloud cloud = ParsePcd(bytes, "a.pcd");
  EXPECT_FALSE(cloud.organised);
  EXPECT_EQ(cloud.p_lidar[1], Vec3f(4, -3, 1.25));
  EXPECT_FLOAT_EQ(cloud.time_s[1], 0.05f) << "nanoseconds";
  EXPECT_EQ(cloud.ring[1], 8);
  EXPECT_EQ(cloud.kind[0], ReturnKind::kHit);
  EXPECT_EQ(cloud.kind[1], ReturnKind::kDropout);
}

TEST(PcdReader, TimesOfEveryUnitBecomeSecondsAfterTheStamp) {
  const auto read = [](const std::string& field, const std::string& rows) {
    return ParsePcd("VERSION 0.7\nFIELDS x y z " + field +
                        "\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT " +
                        "1\nPOINTS 3\nDATA ascii\n" + rows,
                    "a.pcd");
  };
  struct Case {
    const char* rows;
    std::vector<double> times;
    std::optional<double> stamp;
  };
  for (const Case& c :
       {Case{"1 0 0 0\n1 0 0 0.05\n1 0 0 0.1\n", {0, 0.05, 0.1}, {}},
        Case{"1 0 0 -0.1\n1 0 0 -0.05\n1 0 0 0\n", {-0.1, -0.05, 0.0}, {}},
        Case{"1 0 0 0\n1 0 0 50\n1 0 0 100\n", {0, 0.05, 0.1}, {}},
        Case{"1 0 0 0\n1 0 0 50000\n1 0 0 100000\n", {0, 0.05, 0.1}, {}},
        Case{"1 0 0 0\n1 0 0 5e7\n1 0 0 1e8\n", {0, 0.05, 0.1}, {}},
        Case{"1 0 0 1583840211.5\n1 0 0 1583840211.55\n1 0 0 1583840211.6\n", {0, 0.05, 0.1}, 1583840211.5},
        Case{"1 0 0 12.5\n1 0 0 12.55\n1 0 0 12.6\n", {0, 0.05, 0.1}, 12.5},
        Case{"1 0 0 1583840211500000\n1 0 0 1583840211550000\n1 0 0 1583840211600000\n",
             {0, 0.05, 0.1},
             1583840211.5}}) {
    const RecordedCloud cloud = read("timestamp", c.rows);
    ASSERT_EQ(cloud.time_s.size(), 3u) << c.rows;
    for (size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(static_cast<double>(cloud.time_s[i]), c.times[i], 1e-6) << c.rows;
    ASSERT_EQ(cloud.stamp_s.has_value(), c.stamp.has_value()) << c.rows;
    EXPECT_NEAR(cloud.stamp_s.value_or(0.0), c.stamp.value_or(0.0), 1e-6);
  }
}

TEST(PcdReader, RefusesWhatIsNotAPcdFileNamingTheField) {
  const std::string head =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  const auto changed = [&](const std::string& from, const std::string& to, const std::string& data) {
    std::string text = head;
    text.replace(text.find(from), from.size(), to);
    return text + data;
  };
  const std::string ascii = "DATA ascii\n1 2 3\n4 5 6\n";
  EXPECT_EQ(ErrorOf(head + ascii, ParsePcd), "");
  const std::vector<std::pair<std::string, const char*>> cases = {
      {"", "header"},
      {"PNG\n", "PNG"},
      {head, "DATA"},
      {head + "DATA base64\n", "base64"},
      {head + "DATA ascii\n1.000 2.000 3.000\n", "1 of 2 points"},
      {head + "DATA ascii\n1 2 3\n4 5\n", "'z'"},
      {head + "DATA ascii\n1 2 3\n4 5 6 7\n", "4 values"},
      {head + "DATA ascii\n1 2 3\n4 x 6\n", "'y'"},
      {head + "DATA binary\n12345678901", "ends early"},
      {changed("VERSION 0.7", "VERSION 0.9", ascii), "0.9"},
      {changed("SIZE 4 4 4", "SIZE 4 4 3", ascii), "SIZE of field 'z' is 3"},
      {changed("SIZE 4 4 4", "SIZE 4 4", ascii), "2 entries for 3"},
      {changed("TYPE F F F", "TYPE F Q F", ascii), "'Q'"},
      {changed("COUNT 1 1 1", "COUNT 1 1 0", ascii), "COUNT of field 'z'"},
      {changed("WIDTH 2", "WIDTH 3", ascii), "POINTS is 2"},
      {changed("FIELDS x y z", "FIELDS x y w", ascii), "lack x, y or z"},
      {changed("FIELDS x y z", "FIELDS x y y", ascii), "two FIELDS"},
      {changed("POINTS 2", "POINTS 99999999999999999999", ascii), "POINTS"},
      {changed("WIDTH 2\nHEIGHT 1\nPOINTS 2", "WIDTH 2000000000\nHEIGHT 1\nPOINTS 2000000000",
               "DATA binary\n"),
       "ends early"},
      {changed("WIDTH 2\nHEIGHT 1\nPOINTS 2", "WIDTH 2000000000\nHEIGHT 1\nPOINTS 2000000000",
               "DATA ascii\n"),
       "ends early"},
      {head + "DATA ascii\n1 2 3\n4 5 6e30\n", "point 1: "},
      {head + "VIEWPOINT 0 0 0 2 0 0 0\n" + ascii, "VIEWPOINT"}};
  for (const auto& [bytes, word] : cases) {
    const std::string error = ErrorOf(bytes, ParsePcd);
    EXPECT_NE(error.find(word), std::string::npos) << "'" << error << "' should name " << word;
    EXPECT_EQ(error.rfind("some/file: ", 0), 0u) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(Lzf, UnpacksLiteralsAndOverlappingCopies) {
  // "abc", then 5 bytes from 3 back (overlapping), then a long copy: 7 + 2 + 20 bytes from 1 back.
  std::string packed(
      "\x02"
      "abc"
      "\x60\x02"
      "\xe0\x14\x00",
      9);
  const std::string expected = "abcabcab" + std::string(29, 'b');
  EXPECT_EQ(LzfUnpack(packed, expected.size()), expected);
  EXPECT_FALSE(LzfUnpack(packed, expected.size() - 1));
  EXPECT_FALSE(LzfUnpack(packed, expected.size() + 1));
  EXPECT_FALSE(LzfUnpack(std::string_view(packed).substr(0, 8), expected.size()));
  EXPECT_FALSE(LzfUnpack(packed, size_t{1} << 40));
  EXPECT_FALSE(LzfUnpack(std::string("\x20\x05\x00", 3), 3)) << "a copy from before the beginning";
  if (const auto path = tests::SharedData("room_pair/room_scan1.pcd")) {  // by the Point Cloud Library
    const RecordedCloud cloud = ReadCloud(*path);
    EXPECT_EQ(cloud.size(), 112586u);
    core::Box3 box;
    for (const Vec3f& p : cloud.p_lidar) {
      if (p.allFinite()) box.Extend(p.cast<double>());
    }
    EXPECT_LT(box.Size().maxCoeff(), 60.0);
    EXPECT_GT(box.Size().maxCoeff(), 5.0);
  }
}

TEST(Lzf, PacksAnythingWithinThreePercentAndBack) {
  core::Rng rng(5);
  for (const int alphabet : {1, 2, 5, 256}) {
    for (const size_t size : {0u, 1u, 2u, 3u, 33u, 1000u, 20000u}) {
      std::string bytes;
      for (size_t i = 0; i < size; ++i) bytes.push_back(static_cast<char>(rng.UniformInt(alphabet)));
      const std::string packed = LzfPack(bytes);
      EXPECT_LE(packed.size(), bytes.size() + bytes.size() / 32 + 1);
      EXPECT_EQ(LzfUnpack(packed, size), bytes) << alphabet << " " << size;
    }
  }
  EXPECT_LT(LzfPack(std::string(10000, 'a')).size(), 200u);
}

RecordedCloud SomeCloud(bool organised) {
  core::Rng rng(11);
  RecordedCloud cloud;
  cloud.organised = organised;
  cloud.rows = organised ? 7 : 1;
  cloud.columns = 31;
  for (int i = 0; i < cloud.rows * cloud.columns; ++i) {
    const bool hit = rng.Uniform() < 0.7;
    const float nan = std::nanf("");
    cloud.p_lidar.push_back(
        hit ? Vec3f(1.0f + static_cast<float>(rng.Uniform()), static_cast<float>(rng.Normal()), 0.125f)
            : Vec3f(nan, nan, nan));
    cloud.kind.push_back(hit                   ? ReturnKind::kHit
                         : rng.Uniform() < 0.5 ? ReturnKind::kVoid
                                               : ReturnKind::kDropout);
    cloud.time_s.push_back(0.1f * static_cast<float>(i % cloud.columns) / static_cast<float>(cloud.columns));
    cloud.ring.push_back(static_cast<uint16_t>(i / cloud.columns));
  }
  cloud.T_map_lidar = core::PoseFromXyzYaw(core::Vec3(1, -2, 0.5), 0.7);
  return cloud;
}

void ExpectEqual(const RecordedCloud& a, const RecordedCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a.p_lidar[i].allFinite(), b.p_lidar[i].allFinite());
    ASSERT_TRUE(!a.p_lidar[i].allFinite() || a.p_lidar[i] == b.p_lidar[i]);
  }
  EXPECT_EQ(a.time_s, b.time_s);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.ring, b.ring);
}

TEST(CloudWriter, EveryEncodingReadsBackTheSame) {
  for (const bool organised : {false, true}) {
    const RecordedCloud cloud = SomeCloud(organised);
    for (const auto encoding :
         {CloudEncoding::kAscii, CloudEncoding::kBinary, CloudEncoding::kBinaryCompressed}) {
      const RecordedCloud pcd = ParsePcd(CloudToPcd(cloud, encoding), "a.pcd");
      ExpectEqual(cloud, pcd);
      EXPECT_EQ(pcd.organised, organised);
      EXPECT_EQ(pcd.rows, cloud.rows);
      EXPECT_TRUE(pcd.T_map_lidar.isApprox(cloud.T_map_lidar, 1e-12));
      ExpectEqual(cloud, ParsePlyCloud(CloudToPly(cloud, encoding), "a.ply"));
    }
  }
}

TEST(PlyCloud, SkipsOtherElementsAndPropertiesInEveryFormat) {
  const std::string head =
      "comment made up\nelement camera 2\nproperty list uchar float matrix\nproperty int id\nelement vertex "
      "2\n"
      "property uchar red\nproperty double x\nproperty list ushort short tags\nproperty float z\nproperty "
      "double y\n"
      "property float scalar_time\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    std::string bytes = "ply\nformat " + std::string(format) + " 1.0\n" + head;
    if (std::string(format) == "ascii") {
      bytes += "3 1 2 3 77\n0 78\n255 1.5 2 8 9 3 2 0.25\n0 -4 0 6 5 0.5\n3 0 1 0\n";
    } else {
      const bool big = std::string(format) == "binary_big_endian";
      Put<uint8_t>(&bytes, 3), Put(&bytes, 1.0f, big), Put(&bytes, 2.0f, big), Put(&bytes, 3.0f, big);
      Put(&bytes, 77, big);
      Put<uint8_t>(&bytes, 0), Put(&bytes, 78, big);
      Put<uint8_t>(&bytes, 255), Put(&bytes, 1.5, big), Put<uint16_t>(&bytes, 2, big),
          Put<int16_t>(&bytes, 8, big);
      Put<int16_t>(&bytes, 9, big), Put(&bytes, 3.0f, big), Put(&bytes, 2.0, big), Put(&bytes, 0.25f, big);
      Put<uint8_t>(&bytes, 0), Put(&bytes, -4.0, big), Put<uint16_t>(&bytes, 0, big), Put(&bytes, 6.0f, big);
      Put(&bytes, 5.0, big), Put(&bytes, 0.5f, big);
      Put<uint8_t>(&bytes, 3), Put(&bytes, 0, big), Put(&bytes, 1, big), Put(&bytes, 0, big);
    }
    const RecordedCloud cloud = ParsePlyCloud(bytes, "a.ply");
    ASSERT_EQ(cloud.size(), 2u) << format;
    EXPECT_EQ(cloud.p_lidar[0], Vec3f(1.5, 2, 3)) << format;
    EXPECT_EQ(cloud.p_lidar[1], Vec3f(-4, 5, 6)) << format;
    EXPECT_FLOAT_EQ(cloud.time_s[1], 0.5f) << format;
    const std::string cut = bytes.substr(0, bytes.find("end_header") + 30);
    EXPECT_NE(ErrorOf(cut, ParsePlyCloud).find("end"), std::string::npos) << format;
  }
  EXPECT_NE(ErrorOf("ply\nformat ascii 2.0\n", ParsePlyCloud).find("2.0"), std::string::npos);
  EXPECT_NE(ErrorOf("ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nproperty float y\n"
                    "property float z\nend_header\n1 2 3\n",
                    ParsePlyCloud)
                .find("999999999999"),
            std::string::npos);
}

TEST(KittiBin, IsFourFloatsAPoint) {
  std::string bytes;
  for (const float value : {1.0f, 2.0f, 3.0f, 0.5f, 4.0f, 5.0f, 6.0f, 0.25f}) Put(&bytes, value);
  const RecordedCloud cloud = ParseKittiBin(bytes, "000000.bin");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.p_lidar[1], Vec3f(4, 5, 6));
  EXPECT_NE(ErrorOf(bytes.substr(1), ParseKittiBin).find("31 bytes are not a multiple of 16"),
            std::string::npos);
}

TEST(ReadCloud, NamesTheFileThatIsMissingEmptyOrOfAnotherKind) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "io_clouds";
  core::WriteFileAtomically(folder / "empty.pcd", "");
  core::WriteFileAtomically(folder / "some.las", "LASF");
  for (const char* name : {"missing.pcd", "empty.pcd", "some.las"}) {
    try {
      ReadCloud(folder / name);
      ADD_FAILURE() << name;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace atlas::mapping
