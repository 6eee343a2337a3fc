// A separate folder for each test that writes files.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "experiments/run/run.h"
#include "tests/support/scratch_folder.h"

namespace firn {

class ResultsFolder : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  RunOptions options(const std::string& name) const {
    RunOptions options;
    options.results_file = path(name);
    return options;
  }

  const test::ScratchFolder folder_{"results"};
  const std::filesystem::path directory_ = folder_.path();
};

}  // namespace firn
