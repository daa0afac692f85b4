/// A temporary path unique to this process, so that concurrent test runs do not collide.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

namespace ovws {

inline std::string own_folder(const std::string& name) {
  return ::testing::TempDir() + "ovws_" + name + "_" + std::to_string(::getpid());
}

}  // namespace ovws
