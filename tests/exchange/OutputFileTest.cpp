#include "ExchangeFixture.h"

#include <isofront/exchange/OutputFile.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

namespace isofront::exchange::test {

namespace {

class OutputFileTest : public ExchangeTest {};

} // namespace

TEST_F(OutputFileTest, appearsUnderItsNameOnlyWithTheCommit)
{
    setContent(path("a.txt"), "old");
    core::Result<OutputFile> file = OutputFile::create(path("a.txt"));
    ASSERT_TRUE(file) << file.error().message;
    const std::string part(700'000, 'x');
    for (int i = 0; i < 5; ++i)
        file->write(part);
    EXPECT_EQ(contentOf(path("a.txt")), "old");
    EXPECT_EQ(names().size(), 2U);
    const core::Result<std::uint64_t> bytes = file->commit();
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(*bytes, 3'500'000U);
    EXPECT_EQ(contentOf(path("a.txt")), std::string(3'500'000, 'x'));
    EXPECT_EQ(names(), std::vector<std::string>{"a.txt"});
}

TEST_F(OutputFileTest, leavesNothingWhenDroppedOrReplaced)
{
    setContent(path("a.txt"), "old");
    {
        core::Result<OutputFile> file = OutputFile::create(path("a.txt"));
        ASSERT_TRUE(file);
        file->write("new");
        OutputFile moved = std::move(*file);
        moved.write("newer");
        core::Result<OutputFile> other = OutputFile::create(path("b.txt"));
        ASSERT_TRUE(other);
        moved = std::move(*other);
        EXPECT_EQ(names().size(), 2U) << "the first one's temporary file is gone";
    }
    EXPECT_EQ(names(), std::vector<std::string>{"a.txt"});
    EXPECT_EQ(contentOf(path("a.txt")), "old");
}

TEST_F(OutputFileTest, canBeWrittenTwiceAtOnceAndTheLastCommitWins)
{
    core::Result<OutputFile> first = OutputFile::create(path("a.txt"));
    core::Result<OutputFile> second = OutputFile::create(path("a.txt"));
    ASSERT_TRUE(first && second);
    first->write("first");
    second->write("second");
    ASSERT_TRUE(second->commit());
    ASSERT_TRUE(first->commit());
    EXPECT_EQ(contentOf(path("a.txt")), "first");
}

TEST_F(OutputFileTest, keepsWhoMayReadTheFile)
{
    setContent(path("a.txt"), "old");
    ASSERT_EQ(::chmod(path("a.txt").c_str(), 0640), 0);
    ASSERT_TRUE(writeFile(path("a.txt"), "new"));
    EXPECT_EQ(std::filesystem::status(path("a.txt")).permissions(), std::filesystem::perms(0640));
}

TEST_F(OutputFileTest, followsALinkAndKeepsIt)
{
    setContent(path("real.txt"), "old");
    std::filesystem::create_symlink("real.txt", path("link.txt"));
    ASSERT_TRUE(writeFile(path("link.txt"), "new"));
    EXPECT_TRUE(std::filesystem::is_symlink(path("link.txt")));
    EXPECT_EQ(contentOf(path("real.txt")), "new");
}

TEST_F(OutputFileTest, writesIntoAPipe)
{
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    std::string got;
    std::jthread reader([&] { got = contentOf(path("pipe")); });
    const core::Result<std::uint64_t> bytes = writeFile(path("pipe"), std::string(100'000, 'p'));
    reader.join();
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(*bytes, 100'000U);
    EXPECT_EQ(got, std::string(100'000, 'p'));
}

TEST_F(OutputFileTest, takesNamesAsLongAsTheFileSystemDoes)
{
    const std::string longest(255, 'n');
    ASSERT_TRUE(writeFile(path(longest), "x"));
    EXPECT_EQ(contentOf(path(longest)), "x");
    const auto tooLong = writeFile(path(longest + "n"), "x");
    ASSERT_FALSE(tooLong);
    EXPECT_NE(tooLong.error().message.find("choose a shorter name"), std::string::npos);
}

TEST_F(OutputFileTest, saysWhatToDoAboutAPlaceThatCannotBeWritten)
{
    setContent(path("file"), "not a folder");
    const std::pair<std::filesystem::path, const char*> cases[] = {
        {path("missing") / "a.txt", "create the folder first"},
        {path("file") / "a.txt", "create the folder first"},
        {folder(), "name a file in it"},
        {folder() / "", "name a file in it"},
        {"", "name a file in it"},
    };
    for (const auto& [place, remedy] : cases) {
        const auto written = writeFile(place, "x");
        ASSERT_FALSE(written) << place;
        EXPECT_EQ(written.error().code, core::ErrorCode::inputOutput);
        EXPECT_NE(written.error().message.find(remedy), std::string::npos)
            << written.error().message;
        EXPECT_NE(
            written.error().message.find("can't write \"" + place.string()), std::string::npos);
    }
}

TEST_F(OutputFileTest, refusesAFolderOrAFileWithoutPermission)
{
    // The superuser may write anywhere, so a child without its rights tries.
    std::filesystem::create_directory(path("closed"));
    setContent(path("locked.txt"), "old");
    ASSERT_EQ(::chmod(path("locked.txt").c_str(), 0444), 0);
    ASSERT_EQ(::chmod(path("closed").c_str(), 0555), 0);
    ASSERT_EQ(::chmod(folder().c_str(), 0777), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0))
            ::_exit(3);
        const auto isRefused = [](const core::Result<std::uint64_t>& written) {
            return !written && written.error().code == core::ErrorCode::inputOutput &&
                   written.error().message.find("choose a place that you may write to") !=
                       std::string::npos;
        };
        const bool folderRefused = isRefused(writeFile(path("closed") / "a.txt", "x"));
        const bool fileRefused = isRefused(writeFile(path("locked.txt"), "x"));
        ::_exit(folderRefused && fileRefused ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(contentOf(path("locked.txt")), "old");
    EXPECT_TRUE(std::filesystem::is_empty(path("closed")));
}

} // namespace isofront::exchange::test
