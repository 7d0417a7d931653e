#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <random>
#include <utility>

namespace isofront::volume {
namespace {

using core::ErrorCode;

/// Files that must be refused with one clear sentence. Most are refused by their headers, in builds
/// without readers too.
class HostileFiles : public testing::Test {
protected:
    void expectRefused(
        const std::filesystem::path& path,
        ErrorCode code,
        const std::string& part,
        const LoadOptions& options = {})
    {
        const auto volume = loadVolume(path, options);
        ASSERT_FALSE(volume) << path;
        EXPECT_EQ(volume.error().code, code) << volume.error().message;
        EXPECT_NE(volume.error().message.find(part), std::string::npos) << volume.error().message;
        EXPECT_TRUE(volume.error().message.starts_with(path.string())) << volume.error().message;
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos) << volume.error().message;
    }

    void expectRefused(
        const std::string& name, const std::string& bytes, ErrorCode code, const std::string& part)
    {
        expectRefused(folder.file(name, bytes), code, part);
    }

    /// Refused by the reader itself: without it, for the lack of it.
    void expectReaderRefuses(
        const std::string& name,
        const std::string& bytes,
        [[maybe_unused]] const std::string& part = "can't be read as")
    {
#ifdef ISOFRONT_WITH_ITK
        expectRefused(name, bytes, ErrorCode::badData, part);
#else
        expectRefused(name, bytes, ErrorCode::usage, "ISOFRONT_WITH_ITK");
#endif
    }

    test::TemporaryFolder folder;
};

const std::string k64(64, 'x');

TEST_F(HostileFiles, thatAreMissingOrUnreadableAreInputOutputErrors)
{
    expectRefused(folder.path("none.nrrd"), ErrorCode::inputOutput, "no such file");
    expectRefused(folder.path("none/none.vdb"), ErrorCode::inputOutput, "no such file");
    std::filesystem::create_symlink("/dev/null", folder.path("device.nii"));
    expectRefused(folder.path("device.nii"), ErrorCode::inputOutput, "not a regular file");
    const auto locked = folder.file("locked.nrrd", test::nrrdHeader("uint8", "4 4 4") + k64);
    std::filesystem::permissions(locked, std::filesystem::perms::none);
    if (!std::ifstream(locked)) // the superuser may read everything
        expectRefused(locked, ErrorCode::inputOutput, "can't be opened");
}

TEST_F(HostileFiles, ofUnknownExtensionListTheKnownOnes)
{
    for (const char* name : {"volume.txt", "volume", "volume.gz", ".vdbx", "volume.nrrd.bz2"})
        expectRefused(name, "x", ErrorCode::usage, ".nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd, .vdb");
}

TEST_F(HostileFiles, thatAreEmptyOrOfAnotherKindAreBadData)
{
    for (const char* extension : {".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd", ".vdb"}) {
        expectRefused(std::string("empty") + extension, "", ErrorCode::badData, "empty");
        expectRefused(
            std::string("text") + extension,
            std::string(1000, 'a') + "\nhello\n",
            ErrorCode::badData,
            "");
        expectRefused(
            std::string("zero") + extension, std::string(100'000, '\0'), ErrorCode::badData, "");
        expectRefused(std::string("short") + extension, "N", ErrorCode::badData, "");
    }
}

TEST_F(HostileFiles, ofNrrdWithWrongHeadersAreBadData)
{
    const auto header = [](const std::string& sizes) { return test::nrrdHeader("uint8", sizes); };
    expectRefused("a.nrrd", header("0 4 4") + k64, ErrorCode::badData, "at least one");
    expectRefused("b.nrrd", header("-4 4 4") + k64, ErrorCode::badData, "at least one");
    expectRefused("c.nrrd", header("4 4 x") + k64, ErrorCode::badData, "sizes");
    expectRefused("d.nrrd", header("99999999999999999999 4 4"), ErrorCode::badData, "sizes");
    expectRefused("e.nrrd", header("8 8") + k64, ErrorCode::badData, "2 axes");
    expectRefused("f.nrrd", header("2 4 4 2") + k64, ErrorCode::badData, "4 axes");
    expectRefused("g.nrrd", header("2000000000 1 1") + k64, ErrorCode::badData, "2^30");
    expectRefused("h.nrrd", header("4 4 5") + k64, ErrorCode::badData, "cut short");
    expectRefused("i.nrrd", header("1000000 1000000 1000000"), ErrorCode::badData, "cut short");
    expectRefused(
        "j.nrrd",
        test::nrrdHeader("uint8", "1000000 1000000 1000000", "gzip") + k64,
        ErrorCode::badData,
        "cut short");
    expectRefused("k.nrrd", test::nrrdHeader("int128", "2 2 2"), ErrorCode::badData, "int128");
    expectRefused("l.nrrd", test::nrrdHeader("block", "2 2 2") + k64, ErrorCode::badData, "block");
    expectRefused(
        "m.nrrd",
        test::nrrdHeader("uint8", "4 4 4", "ascii") + "1 2 3",
        ErrorCode::badData,
        "cut short");
    expectRefused(
        "n.nrrd", test::nrrdHeader("uint8", "4 4 4", "hex") + k64, ErrorCode::badData, "cut short");
    expectRefused("o.nrrd", "NRRD0004\n\n" + k64, ErrorCode::badData, "\"type\"");
    // what one library takes for a line, and another for two
    for (const std::string& hidden :
         {std::string("# a\rdata file: /etc/passwd"),
          std::string("# a\vb"),
          std::string("# a\0b", 5),
          std::string("#\x7f"),
          std::string("# a\r\r")})
        expectRefused(
            "hidden.nrrd",
            "NRRD0004\n" + hidden + "\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n" +
                k64,
            ErrorCode::badData,
            "control characters");
    for (const std::string& hidden :
         {std::string("Comment = a\rElementDataFile = x"), std::string("Comment\0 = a", 12)})
        expectRefused(
            "hidden.mha",
            hidden +
                "\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                k64,
            ErrorCode::badData,
            "control characters");
    expectRefused("p.nrrd", "NRRD0004\ntype: uint8\n", ErrorCode::badData, "");
    expectRefused(
        "q.nhdr",
        test::nrrdHeader("uint8", "4 4 4", "raw", "data file: none.raw\n"),
        ErrorCode::inputOutput,
        "none.raw");
}

TEST_F(HostileFiles, ofCompressedNrrdCutShortOrDamagedAreBadData)
{
    std::string bytes(64 * 64 * 64, '\0');
    std::uint32_t state = 1;
    for (char& byte : bytes)
        byte = static_cast<char>((state = state * 1664525U + 1013904223U) >> 26U);
    const std::string packed = test::gzipped(bytes);
    const std::string header = test::nrrdHeader("uint8", "64 64 64", "gzip");
    for (const std::size_t part : {2U, 3U, 10U})
        expectReaderRefuses(
            "cut.nrrd",
            header + packed.substr(0, packed.size() / part),
            "cut short: they unpack to");
    expectReaderRefuses(
        "less.nrrd",
        header + test::gzipped(bytes.substr(0, bytes.size() - 1)),
        "unpack to 262143 of 262144 bytes");
    std::string damaged = packed;
    damaged[damaged.size() / 2] ^= 0x55;
    expectReaderRefuses("damaged.nrrd", header + damaged);
}

TEST_F(HostileFiles, ofNiftiWithWrongHeadersAreBadData)
{
    const auto file = [](auto change) {
        test::NiftiOptions options;
        change(options);
        return test::niftiHeader(options) + k64;
    };
    using Options = test::NiftiOptions;
    expectRefused(
        "a.nii",
        file([](Options& o) {
            o.dimensions = {0, 4, 4};
        }),
        ErrorCode::badData,
        "at least one");
    expectRefused(
        "b.nii",
        file([](Options& o) {
            o.dimensions = {-4, 4, 4};
        }),
        ErrorCode::badData,
        "at least one");
    expectRefused(
        "c.nii",
        file([](Options& o) {
            o.dimensions = {8, 8};
        }),
        ErrorCode::badData,
        "2 axes");
    expectRefused(
        "d.nii",
        file([](Options& o) {
            o.dimensions = {4, 4, 2, 2};
        }),
        ErrorCode::badData,
        "more than three");
    expectRefused(
        "e.nii",
        file([](Options& o) {
            o.dimensions = {4, 4, 5};
        }),
        ErrorCode::badData,
        "cut short");
    expectRefused(
        "f.nii",
        file([](Options& o) {
            o.dimensions = {32000, 32000, 32000};
        }),
        ErrorCode::badData,
        "cut short");
    expectRefused("g.nii", file([](Options& o) { o.type = 128; }), ErrorCode::badData, "type 128");
    expectRefused("h.nii", file([](Options& o) { o.offset = 10; }), ErrorCode::badData, "inside");
    expectRefused("i.nii", file([](Options& o) { o.offset = 1e30F; }), ErrorCode::badData, "");
    expectRefused(
        "j.nii.gz",
        test::gzipped(file([](Options& o) {
            o.dimensions = {32000, 32000, 32000};
        })),
        ErrorCode::badData,
        "cut short");
    expectRefused(
        "k.nii.gz", test::gzipped(file([](Options&) {})).substr(0, 40), ErrorCode::badData, "");
}

TEST_F(HostileFiles, ofCompressedNiftiCutShortAreBadData)
{
    std::string bytes(64 * 64 * 64, '\0');
    std::uint32_t state = 1;
    for (char& byte : bytes)
        byte = static_cast<char>((state = state * 1664525U + 1013904223U) >> 26U);
    test::NiftiOptions options;
    options.dimensions = {64, 64, 64};
    const std::string packed = test::gzipped(test::niftiHeader(options) + bytes);
    expectRefused("cut.nii.gz", packed.substr(0, packed.size() / 2), ErrorCode::badData, "unpack");
    expectRefused(
        "less.nii.gz",
        test::gzipped(test::niftiHeader(options) + bytes.substr(0, bytes.size() - 1)),
        ErrorCode::badData,
        "unpack");
}

TEST_F(HostileFiles, ofMetaImageWithWrongHeadersAreBadData)
{
    using test::metaHeader;
    expectRefused("a.mha", metaHeader("0 4 4") + k64, ErrorCode::badData, "at least one");
    expectRefused("b.mha", metaHeader("-4 4 4") + k64, ErrorCode::badData, "at least one");
    expectRefused("c.mha", metaHeader("4 4 5") + k64, ErrorCode::badData, "cut short");
    expectRefused("d.mha", metaHeader("4 4") + k64, ErrorCode::badData, "DimSize");
    expectRefused("e.mha", metaHeader("100000 100000 100000"), ErrorCode::badData, "cut short");
    expectRefused(
        "f.mha",
        metaHeader("4 4 4", "ElementNumberOfChannels = 3\n") + k64 + k64 + k64,
        ErrorCode::badData,
        "3 values a voxel");
    expectRefused(
        "g.mha", metaHeader("4 4 4", "BinaryData = False\n") + k64, ErrorCode::badData, "text");
    expectRefused("h.mhd", metaHeader("4 4 4", "", "none.raw"), ErrorCode::inputOutput, "none.raw");
    expectRefused("i.mhd", metaHeader("4 4 4", "", "LIST"), ErrorCode::badData, "several files");
    expectRefused("j.mha", "NDims = 3\n", ErrorCode::badData, "ElementDataFile");
    const std::string packed = test::zlibbed(std::string(64 * 64, 'a') + k64);
    expectRefused(
        "k.mha",
        metaHeader("65 64 1", "CompressedData = True\n") + packed.substr(0, packed.size() / 2),
        ErrorCode::badData,
        "unpack");
    expectRefused(
        "l.mha",
        metaHeader("65 64 1", "CompressedData = True\nCompressedDataSize = 10\n") + packed,
        ErrorCode::badData,
        "unpack");
    expectRefused(
        "m.mha",
        metaHeader("65 64 1", "CompressedData = True\n") + std::string(500, 'z'),
        ErrorCode::badData,
        "unpack");
}

TEST_F(HostileFiles, aboveTheMemoryLimitAreRefusedBeforeMemoryIsTaken)
{
    const auto path = folder.file("a.nrrd", test::nrrdHeader("uint8", "4 4 4") + k64);
    expectRefused(path, ErrorCode::resourceLimit, "limit", {.memoryLimit = 63});

    // Sparse on the disk, so that the header is right: 2^40 bytes.
    const auto large = folder.file("b.nrrd", test::nrrdHeader("uint8", "65536 65536 256"));
    std::error_code failed;
    std::filesystem::resize_file(large, (std::uintmax_t{1} << 40U) + 4096, failed);
    if (!failed)
        expectRefused(large, ErrorCode::resourceLimit, "limit");
}

TEST_F(HostileFiles, ofVdbCutShortAreBadDataAtEveryLength)
{
    // The beginning of a VDB file: magic, version, library, index flag, and nothing after it.
    std::string bytes("\x20\x42\x44\x56\0\0\0\0\xe0\0\0\0\x0a\0\0\0\0\0\0\0\x01", 21);
    bytes += std::string(36, '0'); // UUID
    bytes += std::string(4, '\0'); // no metadata
    bytes += std::string("\x01\0\0\0", 4);
    bytes += std::string("\x07\0\0\0density", 11);
    for (std::size_t length = 1; length < bytes.size(); ++length)
        expectRefused("cut.vdb", bytes.substr(0, length), ErrorCode::badData, "");
    expectRefused(
        "name.vdb",
        bytes.substr(0, 65) + std::string("\xff\xff\xff\xff", 4),
        ErrorCode::badData,
        "damaged");
    std::string old = bytes;
    old[8] = '\xd0';
    expectRefused("old.vdb", old, ErrorCode::badData, "version 208");
    std::string stream = bytes;
    stream[20] = '\0';
    expectRefused("stream.vdb", stream, ErrorCode::badData, "stream");
}

TEST_F(HostileFiles, withRandomHeadersNeverCrash)
{
    std::mt19937 random(20);
    const std::string nrrd = test::nrrdHeader("uint8", "4 4 4") + k64;
    const std::string meta = test::metaHeader("4 4 4") + k64;
    const std::string nifti = test::niftiHeader({}) + k64;
    for (int i = 0; i < 200; ++i) {
        for (const auto& [name, good] :
             {std::pair{"r.nrrd", nrrd}, std::pair{"r.mha", meta}, std::pair{"r.nii", nifti}}) {
            std::string bad = good;
            for (std::uint32_t change = 0; change < 1 + random() % 3; ++change)
                bad[random() % (bad.size() - 64)] = static_cast<char>(random());
            const auto volume = loadVolume(folder.file(name, bad), {.memoryLimit = 1U << 20U});
            EXPECT_TRUE(volume || !volume.error().message.empty());
        }
    }
}

} // namespace
} // namespace isofront::volume
