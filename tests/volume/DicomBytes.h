#pragma once

#include "support/FileBytes.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace isofront::test {

/// A CT slice as a DICOM file, written by the letter of PS3.5 and PS3.10.
struct DicomSlice {
    std::uint16_t columns = 4;
    std::uint16_t rows = 3;
    std::vector<std::int16_t> pixels; ///< stored values
    std::array<double, 3> position{0, 0, 0};
    std::array<double, 6> orientation{1, 0, 0, 0, 1, 0};
    std::array<double, 2> pixelSpacing{1, 1}; ///< between rows, between columns
    double slope = 1;
    double intercept = 0;
    int instance = 1;
    std::string series = "1.2.3.4";
    std::string description = "plain";
    bool bigEndian = false;
    bool hasRuns = false; ///< pixels as RLE Lossless
};

/// Bytes as runs and literals, by PS3.5, Annex G.
inline std::string packedBytes(const std::string& bytes)
{
    std::string packed;
    for (std::size_t at = 0; at < bytes.size();) {
        std::size_t run = 1;
        while (at + run < bytes.size() && run < 128 && bytes[at + run] == bytes[at])
            ++run;
        if (run > 1) {
            packed += {static_cast<char>(1 - static_cast<int>(run)), bytes[at]};
            at += run;
            continue;
        }
        std::size_t literals = 1;
        while (
            at + literals < bytes.size() && literals < 128 &&
            (at + literals + 1 == bytes.size() || bytes[at + literals] != bytes[at + literals + 1]))
            ++literals;
        packed += static_cast<char>(literals - 1) + bytes.substr(at, literals);
        at += literals;
    }
    return packed.size() % 2 == 0 ? packed : packed + static_cast<char>(-128);
}

/// Pixels of two bytes in the one fragment of a frame.
inline std::string fragmentOf(const std::vector<std::int16_t>& pixels)
{
    const std::string plain = tests::bytesOf(pixels, false);
    std::array<std::string, 2> segments; // the higher bytes come first
    for (std::size_t i = 0; i < plain.size(); ++i)
        segments[1 - i % 2] += plain[i];
    const std::string first = packedBytes(segments[0]);
    std::vector<std::uint32_t> header(16, 0);
    header[0] = 2;
    header[1] = 64;
    header[2] = static_cast<std::uint32_t>(64 + first.size());
    return tests::bytesOf(header, false) + first + packedBytes(segments[1]);
}

inline std::string dicomBytes(const DicomSlice& slice)
{
    const auto element = [](std::uint16_t group,
                            std::uint16_t number,
                            const std::string& kind,
                            std::string value,
                            bool bigEndian) {
        if (value.size() % 2 != 0)
            value += kind == "UI" ? '\0' : ' ';
        std::string bytes =
            tests::bytesOf(std::vector<std::uint16_t>{group, number}, bigEndian) + kind;
        if (kind == "OB" || kind == "OW")
            bytes +=
                std::string(2, '\0') +
                tests::bytesOf(std::vector{static_cast<std::uint32_t>(value.size())}, bigEndian);
        else
            bytes +=
                tests::bytesOf(std::vector{static_cast<std::uint16_t>(value.size())}, bigEndian);
        return bytes + value;
    };
    const auto decimals = [](auto values) {
        std::string text;
        for (const double value : values) {
            std::array<char, 24> digits{};
            std::snprintf(digits.data(), digits.size(), "%.10g", value);
            text += (text.empty() ? "" : "\\") + std::string(digits.data());
        }
        return text;
    };
    const std::string kind = "1.2.840.10008.5.1.4.1.1.2"; // CT
    const std::string instance = slice.series + "." + std::to_string(slice.instance);
    const std::string meta = element(2, 1, "OB", std::string("\0\1", 2), false) +
                             element(2, 2, "UI", kind, false) +
                             element(2, 3, "UI", instance, false) +
                             element(
                                 2,
                                 0x10,
                                 "UI",
                                 slice.hasRuns     ? "1.2.840.10008.1.2.5"
                                 : slice.bigEndian ? "1.2.840.10008.1.2.2"
                                                   : "1.2.840.10008.1.2.1",
                                 false) +
                             element(2, 0x12, "UI", "1.2.3", false);
    const bool big = slice.bigEndian;
    const auto number = [&](std::uint16_t value) {
        return tests::bytesOf(std::vector{value}, big);
    };
    const auto item = [](std::uint16_t which, std::uint32_t length) {
        return tests::bytesOf(std::vector<std::uint16_t>{0xfffe, which}, false) +
               tests::bytesOf(std::vector{length}, false);
    };
    const std::string fragment = slice.hasRuns ? fragmentOf(slice.pixels) : "";
    const std::string pixels =
        slice.hasRuns ? tests::bytesOf(std::vector<std::uint16_t>{0x7fe0, 0x10}, false) + "OB" +
                            std::string(2, '\0') + std::string(4, '\xff') + item(0xe000, 0) +
                            item(0xe000, static_cast<std::uint32_t>(fragment.size())) + fragment +
                            item(0xe0dd, 0)
                      : element(0x7fe0, 0x10, "OW", tests::bytesOf(slice.pixels, big), big);
    return std::string(128, '\0') + "DICM" +
           element(
               2,
               0,
               "UL",
               tests::bytesOf(std::vector{static_cast<std::uint32_t>(meta.size())}),
               false) +
           meta + element(8, 0x16, "UI", kind, big) + element(8, 0x18, "UI", instance, big) +
           element(8, 0x60, "CS", "CT", big) + element(8, 0x103e, "LO", slice.description, big) +
           element(0x18, 0x50, "DS", "1", big) + element(0x20, 0x0d, "UI", "1.2.3.9", big) +
           element(0x20, 0x0e, "UI", slice.series, big) +
           element(0x20, 0x13, "IS", std::to_string(slice.instance), big) +
           element(0x20, 0x32, "DS", decimals(slice.position), big) +
           element(0x20, 0x37, "DS", decimals(slice.orientation), big) +
           element(0x28, 2, "US", number(1), big) + element(0x28, 4, "CS", "MONOCHROME2", big) +
           element(0x28, 0x10, "US", number(slice.rows), big) +
           element(0x28, 0x11, "US", number(slice.columns), big) +
           element(0x28, 0x30, "DS", decimals(slice.pixelSpacing), big) +
           element(0x28, 0x100, "US", number(16), big) +
           element(0x28, 0x101, "US", number(16), big) +
           element(0x28, 0x102, "US", number(15), big) +
           element(0x28, 0x103, "US", number(1), big) +
           element(0x28, 0x1052, "DS", decimals(std::array{slice.intercept}), big) +
           element(0x28, 0x1053, "DS", decimals(std::array{slice.slope}), big) + pixels;
}

} // namespace isofront::test
