#include <isofront/server/Settings.h>

#include <gtest/gtest.h>

#include <set>

namespace isofront::server {
namespace {

TEST(Settings, lastOneWinsAndSaysWhereItIsFrom)
{
    const std::vector<GivenSetting> given{
        {"port", "1000", "serve.toml"},
        {"port", "2000", "ISOFRONT_SERVE_PORT"},
        {"port", "3000", "--port"},
        {"max-streams", "7", "serve.toml"}};
    for (std::size_t count = 1; count <= 3; ++count) {
        const auto inForce = settingsFrom(std::span(given).first(count));
        ASSERT_TRUE(inForce) << inForce.error().message;
        EXPECT_EQ(inForce->settings.port, 1000 * count);
    }
    const auto inForce = settingsFrom(given);
    ASSERT_TRUE(inForce);
    EXPECT_EQ(inForce->settings.streams, 7U);
    const auto table = settingsTable();
    for (std::size_t i = 0; i < table.size(); ++i)
        EXPECT_EQ(
            inForce->origins[i],
            table[i].name == "port"          ? "--port"
            : table[i].name == "max-streams" ? "serve.toml"
                                             : "")
            << table[i].name;
}

TEST(Settings, whatIsShownLeadsToTheSame)
{
    const std::vector<GivenSetting> given{
        {"host", "0.0.0.0", "a"},
        {"anonymous", "read, write", "a"},
        {"max-upload", "1536MiB", "a"},
        {"max-body", "70000", "a"},
        {"cors-origins", "https://a.example,https://b.example", "a"},
        {"idle-timeout", "12.5", "a"},
        {"log-format", "json", "a"}};
    const auto first = settingsFrom(given);
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(first->settings.uploadBytes, std::uint64_t{1536} << 20U);
    std::vector<GivenSetting> shown;
    for (const Setting& setting : settingsTable())
        shown.push_back({std::string(setting.name), setting.show(first->settings), "shown"});
    const auto second = settingsFrom(shown);
    ASSERT_TRUE(second) << second.error().message;
    for (const Setting& setting : settingsTable())
        EXPECT_EQ(setting.show(first->settings), setting.show(second->settings)) << setting.name;
}

TEST(Settings, ofAFileKnowTheirLines)
{
    const auto given = parseSettings(
        "# of the lab\r\n"
        "\n"
        "  port=9000 # not 8080\r\n"
        "host = \"::1\"# here\n"
        "data = 'C:\\scans # 1'\n"
        "viewer = \"a \\\"b\\\" \\\\c\"\n"
        "cors-origins = [ \"https://a.example\", 'https://b.example' , plain ] # two\n"
        "host-names = []\n"
        "tokens = \"\"\n"
        "sources = my scans",
        "f");
    ASSERT_TRUE(given) << given.error().message;
    const std::vector<GivenSetting> expected{
        {"port", "9000", "f:3"},
        {"host", "::1", "f:4"},
        {"data", "C:\\scans # 1", "f:5"},
        {"viewer", "a \"b\" \\c", "f:6"},
        {"cors-origins", "https://a.example,https://b.example,plain", "f:7"},
        {"host-names", "", "f:8"},
        {"tokens", "", "f:9"},
        {"sources", "my scans", "f:10"}};
    ASSERT_EQ(given->size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ((*given)[i].name, expected[i].name);
        EXPECT_EQ((*given)[i].value, expected[i].value);
        EXPECT_EQ((*given)[i].where, expected[i].where);
    }
}

TEST(Settings, ofAFileAreReadAsTheyAreWritten)
{
    for (const std::string& value :
         {std::string(),
          std::string("plain"),
          std::string("a \"b\" 'c' \\ # [d], \\\""),
          std::string(" = ")}) {
        const auto given = parseSettings("data = " + quotedSetting(value) + "\n", "f");
        ASSERT_TRUE(given) << given.error().message;
        EXPECT_EQ(given->at(0).value, value);
    }
}

TEST(Settings, ofAFileThatCantBeReadNameTheLine)
{
    for (const char* const line :
         {"port",
          "= 5",
          "port =",
          "port = # 5",
          "port = \"5",
          "port = '5",
          "port = \"5\" 6",
          "port = \"\\x\"",
          "port = \"\\",
          "port = [5",
          "port = [5 6",
          "port = [\"5\" 6]",
          "port = [,]",
          "port = [] 5",
          "host = 127.0.0.1"}) {
        const auto given = parseSettings("# first\nhost = ::1\n" + std::string(line) + "\n", "f");
        ASSERT_FALSE(given) << line;
        EXPECT_EQ(given.error().code, core::ErrorCode::usage);
        EXPECT_TRUE(given.error().message.starts_with("f:3: ")) << given.error().message;
    }
}

TEST(Settings, namesAreUniqueAndHaveOneVariableEach)
{
    std::set<std::string_view> names;
    for (const Setting& setting : settingsTable()) {
        EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
        const std::vector<std::string> environment{
            "HOME=/root", environmentName(setting.name) + "=some=thing"};
        const auto given = settingsOfEnvironment(environment);
        ASSERT_EQ(given.size(), 1U);
        EXPECT_EQ(given[0].name, setting.name);
        EXPECT_EQ(given[0].value, "some=thing");
        EXPECT_EQ(given[0].where, environmentName(setting.name));
    }
}

TEST(Settings, refusesWhatMakesNoSenseAndNamesIt)
{
    const std::vector<GivenSetting> wrong{
        {"port", "65536", "x"},
        {"port", "-1", "x"},
        {"port", "80a", "x"},
        {"port", "", "x"},
        {"max-body", "1MB", "x"},
        {"max-body", "12", "x"},
        {"max-body", "-5", "x"},
        {"max-upload", "99999999999999999999", "x"},
        {"max-upload", "18446744073709551615GiB", "x"},
        {"idle-timeout", "nan", "x"},
        {"idle-timeout", "0", "x"},
        {"idle-timeout", "inf", "x"},
        {"log-level", "loud", "x"},
        {"anonymous", "read,root", "x"},
        {"data", "", "x"},
        {"workers", "1.5", "x"},
        {"no-such", "1", "x"},
        {"Port", "1", "x"}};
    for (const GivenSetting& setting : wrong) {
        const auto inForce = settingsFrom(std::span(&setting, 1));
        ASSERT_FALSE(inForce) << setting.name << " = " << setting.value;
        EXPECT_EQ(inForce.error().code, core::ErrorCode::usage);
        EXPECT_TRUE(inForce.error().message.starts_with("x: ")) << inForce.error().message;
        EXPECT_NE(inForce.error().message.find(setting.name), std::string::npos);
    }
}

TEST(Settings, askForTokensWhereOthersCanReachIt)
{
    const auto scopes = [](std::vector<GivenSetting> given) -> std::string {
        const auto inForce = settingsFrom(given);
        if (!inForce)
            return "refused";
        std::string text;
        for (const std::string& scope : inForce->settings.anonymous)
            text += scope + " ";
        return text;
    };
    EXPECT_EQ(scopes({}), "read write admin ");
    EXPECT_EQ(scopes({{"host", "127.3.2.1", "x"}}), "read write admin ");
    EXPECT_EQ(scopes({{"host", "::1", "x"}}), "read write admin ");
    EXPECT_EQ(scopes({{"host", "0.0.0.0", "x"}}), "refused");
    EXPECT_EQ(scopes({{"host", "127.0.0.1.example.org", "x"}}), "refused");
    EXPECT_EQ(scopes({{"host", "0.0.0.0", "x"}, {"tokens", "file", "x"}}), "");
    EXPECT_EQ(scopes({{"host", "0.0.0.0", "x"}, {"anonymous", "read", "x"}}), "read ");
    EXPECT_EQ(scopes({{"tokens", "file", "x"}}), "");
    EXPECT_EQ(scopes({{"anonymous", "", "x"}}), "");
}

} // namespace
} // namespace isofront::server
