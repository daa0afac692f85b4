#include "daemon/web/commands.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

TEST(Commands, ThatOnlyReadChangeNothing) {
  for (const char* method : {"job.get", "record.list", "loop.model", "slm.verify"}) {
    EXPECT_FALSE(changes_bench({method, {}})) << method;
  }
  for (const char* method : {"camera.set", "focus.run", "reference.delete", "loop.open"}) {
    EXPECT_TRUE(changes_bench({method, {}})) << method;
  }
}

TEST(CommandsTest, TakesWhatThePageNeeds) {
  const auto command = parse_command(R"({"method": "camera.set", "params": {"gain_db": 3}})");
  ASSERT_TRUE(command);
  EXPECT_EQ(command->method, "camera.set");
  EXPECT_EQ(command->params["gain_db"], 3);
  for (const char* method :  // of the buttons of findings
       {"aberration.clear", "camera.auto_exposure", "reference.take", "slm.show"}) {
    EXPECT_TRUE(parse_command(nlohmann::json{{"method", method}}.dump())) << method;
  }
}

TEST(CommandsTest, RefusesEveryOtherMethod) {
  for (const char* method : {"focus.run", "refine.set", "system.status", "camera.set ", ""}) {
    const nlohmann::json body{{"method", method}};
    const auto command = parse_command(body.dump());
    ASSERT_FALSE(command) << method;
    EXPECT_EQ(command.error(), Refusal::command);
  }
}

TEST(CommandsTest, RefusesWhatIsNoCommand) {
  const std::string deep = R"({"method":"camera.set","params":)" + std::string(5000, '[');
  for (const std::string& body :
       {std::string{}, std::string{"[]"}, std::string{"{}"}, std::string{R"({"method": 3})"},
        std::string{R"({"method": "camera.set", "params": []})"},
        std::string{R"({"method": "camera.set", "method": "slm.show"})"}, deep,
        std::string("\xff\xfe\0", 3)}) {
    const auto command = parse_command(body);
    ASSERT_FALSE(command) << body.substr(0, 60);
    EXPECT_EQ(command.error(), Refusal::malformed);
  }
}

}  // namespace
}  // namespace ovws::web
