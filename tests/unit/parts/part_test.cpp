#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "daemon/ovws/parts/part_file.hpp"
#include "daemon/ovws/parts/provenance.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Part : public testing::Test {
 protected:
  Part() : folder_(fs::temp_directory_path() / ("ovws-part-" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
  }
  ~Part() override { fs::remove_all(folder_); }

  static PartHead head(const std::string& share) {
    PartHead head;
    head.part_of = "replay";
    head.version = "1";
    head.options = {{"seed", 1}, {"recording", {{"frames", 6}}}};
    head.items = 6;
    head.share = share;
    return head;
  }
  std::string write(const std::string& name, const PartHead& head,
                    const std::vector<std::uint64_t>& items) {
    const auto fill = [&](const AddItem& add) -> Result<void> {
      for (const std::uint64_t item : items) add(item, "[" + std::to_string(item) + ",0.1]");
      return {};
    };
    return write_part(folder_, name, head, fill).value();
  }
  /// All results joined, or the error's reason.
  static std::string merged(const std::vector<std::string>& paths) {
    auto reader = PartReader::open(paths);
    if (!reader) return reader.error().reason;
    std::string text;
    while (true) {
      auto item = reader->next();
      if (!item) return item.error().reason;
      if (!*item) return text;
      text += (*item)->result.dump();
    }
  }
  static void expect(const std::string& reason, const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      EXPECT_NE(reason.find(word), std::string::npos) << reason << " lacks " << word;
    }
  }

  const fs::path folder_;
  const std::string whole_ = "[0,0.1][1,0.1][2,0.1][3,0.1][4,0.1][5,0.1]";
};

TEST_F(Part, shards_and_ranges_join_in_any_order) {
  const std::string odd = write("a", head("1/2"), {0, 2, 4}),
                    even = write("b", head("2/2"), {1, 3, 5});
  EXPECT_EQ(merged({odd, even}), whole_);
  EXPECT_EQ(merged({even, odd}), whole_);
  EXPECT_EQ(merged({write("c", head("0:6"), {0, 1, 2, 3, 4, 5})}), whole_);
  const std::string none = write("d", head("2:2"), {}), first = write("e", head("0:2"), {0, 1});
  EXPECT_EQ(merged({write("f", head("2:6"), {2, 3, 4, 5}), none, first}), whole_);
}

TEST_F(Part, missing_and_double_parts_are_named) {
  const std::string a = write("a", head("1/3"), {0, 3}), b = write("b", head("2/3"), {1, 4});
  expect(merged({a, b}), {"missing shards: 3/3"});
  expect(merged({a}), {"2/3, 3/3"});
  expect(merged({a, b, a}), {"shard 1/3 is there twice", a});
  expect(merged({a, write("c", head("2/2"), {1})}), {a, "c.jsonl", "one of 3", "one of 2"});
  const std::string x = write("x", head("0:2"), {0, 1}), y = write("y", head("4:6"), {4, 5});
  expect(merged({y, x}), {"missing positions: 2:4"});
  expect(merged({x}), {"missing positions: 2:6"});
  expect(merged({x, y, write("z", head("1:4"), {1, 2, 3})}),
         {"1:2 are there twice", "x.jsonl", "z.jsonl"});
  expect(merged({x, a}), {a, "1/3", "A:B"});
}

TEST_F(Part, parts_that_do_not_belong_together_are_named_with_the_difference) {
  const std::string a = write("a", head("1/2"), {0, 2, 4});
  PartHead other = head("2/2");
  other.version = "2";
  expect(merged({a, write("b", other, {1, 3, 5})}), {a, "b.jsonl", "version: \"1\" and \"2\""});
  other = head("2/2");
  other.options["seed"] = 2;
  other.options["recording"]["frames"] = 7;
  expect(merged({a, write("c", other, {1, 3, 5})}),
         {"options/seed: 1 and 2", "options/recording/frames: 6 and 7"});
  other = head("2/2");
  other.part_of = "study range";
  other.options["quick"] = true;
  expect(merged({a, write("d", other, {1, 3, 5})}),
         {"study range", "options/quick: null and true"});
}

TEST_F(Part, a_damaged_part_is_named) {
  const std::string a = write("a", head("1/2"), {0, 2, 4});
  expect(merged({a, write("b", head("2/2"), {1, 5})}), {"item 3 is missing"});
  expect(merged({a, write("c", head("2/2"), {1, 3, 4, 5})}),
         {"item 4 is there twice", "a.jsonl", "c.jsonl"});
  expect(merged({a, write("d", head("2/2"), {1, 3, 5, 6})}), {"must not be"});
  expect(merged({a, write("e", head("2/2"), {5, 3, 1})}), {"item 1 is missing"});
  const std::string f = write("f", head("2/2"), {1, 3, 5});
  fs::resize_file(f, fs::file_size(f) - 4);
  expect(merged({a, f}), {"f.jsonl is damaged"});
  std::ofstream(folder_ / "g.jsonl") << "{\"item\":1}\n";
  expect(merged({a, folder_ / "g.jsonl"}), {"g.jsonl is not a part"});
  expect(merged({folder_ / "none.jsonl"}), {"none.jsonl cannot be read"});
}

TEST_F(Part, an_unfinished_part_leaves_nothing_and_a_finished_one_its_provenance) {
  const auto stop = [&](const AddItem& add) -> Result<void> {
    add(0, "[]");
    EXPECT_FALSE(fs::exists(folder_ / "part.jsonl"));
    return fail(Errc::refused, "", "no more");
  };
  EXPECT_FALSE(write_part(folder_, "part", head("1/1"), stop));
  EXPECT_TRUE(fs::is_empty(folder_));
  const json facts = facts_of_part(write("part", head("1/1"), {0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(facts.at("host"), host_name());
  EXPECT_EQ(facts.at("part"), "part.jsonl");
  EXPECT_GE(facts.at("took_s").get<double>(), 0.0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
  EXPECT_FALSE(write_part("/proc/nowhere", "part", head("1/1"), stop));
}

}  // namespace
}  // namespace ovws
