// Based on: Wavefront Technologies, "Advanced Visualizer Manual", appendix B1 (object files).

#include "MeshFormats.h"

#include <charconv>
#include <string>

namespace isofront::exchange {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 16U;

/// The shortest text that reads back as the same number (at most 17 digits of a double, 9 of a
/// float), whatever the locale.
template <typename T>
void append(std::string& text, T number)
{
    char digits[40];
    const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, number);
    text.append(digits, end.ptr);
}

template <typename Vector>
void appendLine(std::string& text, const char* keyword, const Vector& v)
{
    text += keyword;
    for (const auto number : {v.x, v.y, v.z}) {
        text += ' ';
        append(text, number);
    }
    text += '\n';
}

} // namespace

core::Result<void> writeObj(const MeshJob& job)
{
    const MeshView& mesh = job.mesh;
    std::string text = "# " + inOneLine(job.options.generator) + "\n";
    for (const auto& [key, value] : job.options.settings)
        text += "# " + inOneLine(key) + " " + inOneLine(value) + "\n";
    if (!mesh.isEmpty())
        text += "o " + inOneLine(job.options.name) + "\n";

    const auto writeFullBlock = [&] {
        if (text.size() >= kBlockBytes) {
            job.file.write(text);
            text.clear();
        }
    };
    for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
        appendLine(text, "v", mesh.position(vertex));
        writeFullBlock();
    }
    if (mesh.hasNormals())
        for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
            appendLine(text, "vn", mesh.normal(vertex));
            writeFullBlock();
        }
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        text += 'f';
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint64_t number = std::uint64_t{mesh.triangle(triangle)[corner]} + 1;
            text += ' ';
            append(text, number);
            if (mesh.hasNormals()) {
                text += "//";
                append(text, number);
            }
        }
        text += '\n';
        writeFullBlock();
    }
    job.file.write(text);
    return {};
}

} // namespace isofront::exchange
