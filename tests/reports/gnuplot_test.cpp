#include "reports/gnuplot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "solver/types.h"

namespace firn {
namespace {

TEST(Gnuplot, DrawsAPicture) {
  const std::string file = testing::TempDir() + "gnuplot's picture.png";
  std::filesystem::remove(file);
  const Gnuplot gnuplot;
  gnuplot.run(Gnuplot::output(file, 200, 100) + "plot x\n");
  EXPECT_GT(std::filesystem::file_size(file), 500u);
}

TEST(Gnuplot, AWrongScriptIsARunErrorOfOneLine) {
  const Gnuplot gnuplot;
  try {
    gnuplot.run("plot nothing_such(x)\n");
    FAIL();
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("gnuplot: "));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

TEST(Gnuplot, MissingProgramIsTheUsersToInstall) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  EXPECT_THROW(Gnuplot().run("plot x\n"), InputError);
  setenv("PATH", path.c_str(), 1);
}

TEST(Gnuplot, KnowsPngAndSvgOnly) {
  EXPECT_THAT(Gnuplot::output("a.svg", 1, 1), testing::HasSubstr("set terminal svg"));
  EXPECT_THROW(Gnuplot::output("a.jpg", 1, 1), InputError);
}

TEST(Gnuplot, TheFolderGoesWithTheObject) {
  std::filesystem::path folder;
  {
    const Gnuplot gnuplot;
    folder = gnuplot.data_file("x").parent_path();
    EXPECT_TRUE(std::filesystem::exists(folder));
  }
  EXPECT_FALSE(std::filesystem::exists(folder));
}

}  // namespace
}  // namespace firn
