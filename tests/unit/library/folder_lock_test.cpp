#include "daemon/ovwsd/library/state_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

class FolderLockTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }
  const std::string folder_ = own_folder("folder_lock");
};

TEST_F(FolderLockTest, ASecondOwnerIsRefusedWithTheWayOut) {
  const auto first = lock_folder(folder_ + "/state");
  ASSERT_TRUE(first);
  ASSERT_TRUE(*first);
  const auto second = lock_folder(folder_ + "/state");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().field, "state.directory");
  EXPECT_NE(second.error().reason.find(folder_), std::string::npos) << second.error().reason;
  EXPECT_TRUE(lock_folder(folder_ + "/other"));
}

TEST_F(FolderLockTest, TheFolderIsFreeWhenTheLastCopyIsGone) {
  auto first = lock_folder(folder_);
  auto copy = *first;
  first = FolderLock();
  EXPECT_FALSE(lock_folder(folder_));
  copy.reset();
  EXPECT_TRUE(lock_folder(folder_));
}

TEST_F(FolderLockTest, WhatCannotBeLockedIsNoError) {
  const auto lock = lock_folder("/proc/ovws");
  ASSERT_TRUE(lock);
  EXPECT_FALSE(*lock);
}

}  // namespace
}  // namespace ovws
