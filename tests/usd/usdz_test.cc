#include "deepslam/usd/usdz.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::usd {
namespace {

std::uint32_t NumberAt(const std::string& zip, std::size_t at, std::size_t bytes) {
  std::uint32_t number = 0;
  for (std::size_t n = bytes; n-- > 0;)
    number = number << 8U | static_cast<unsigned char>(zip[at + n]);
  return number;
}

TEST(WriteUsdz, FilesAreStoredWholeAndAligned) {
  // Names and sizes of every remainder by 64.
  for (std::size_t extra = 0; extra < 70; ++extra) {
    const std::vector<PackagedFile> files = {{"scene.usda", std::string(extra, 'a')},
                                             {std::string(extra + 1, 'n') + ".png", "second"}};
    const Result<std::string> zip = WriteUsdz(files);
    ASSERT_TRUE(zip.ok());
    std::size_t at = 0;
    for (const PackagedFile& file : files) {
      ASSERT_EQ(NumberAt(*zip, at, 4), 0x04034b50U);
      EXPECT_EQ(NumberAt(*zip, at + 8, 2), 0U) << "stored";
      const std::size_t name = NumberAt(*zip, at + 26, 2);
      const std::size_t padding = NumberAt(*zip, at + 28, 2);
      EXPECT_EQ(zip->substr(at + 30, name), file.name);
      const std::size_t begin = at + 30 + name + padding;
      EXPECT_EQ(begin % 64, 0U);
      EXPECT_EQ(zip->substr(begin, file.bytes.size()), file.bytes);
      at = begin + file.bytes.size();
    }
    EXPECT_EQ(NumberAt(*zip, at, 4), 0x02014b50U) << "the directory follows";
  }
}

TEST(WriteUsdz, HasTheKnownChecksum) {
  const Result<std::string> zip = WriteUsdz(std::vector<PackagedFile>{{"a.usda", "123456789"}});
  ASSERT_TRUE(zip.ok());
  EXPECT_EQ(NumberAt(*zip, 14, 4), 0xCBF43926U);  // the check value of CRC-32
}

TEST(WriteUsdz, BearsNoFiles) { EXPECT_TRUE(WriteUsdz({}).ok()); }

}  // namespace
}  // namespace deepslam::usd
