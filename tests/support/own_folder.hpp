/// A folder's path that no other process uses: two runs of the tests may share a machine.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

namespace ovws {

inline std::string own_folder(const std::string& name) {
  return ::testing::TempDir() + "ovws_" + name + "_" + std::to_string(::getpid());
}

}  // namespace ovws
