#include "isofront/exchange/MeshFile.h"

#include "MeshFormats.h"
#include "MeshView.h"
#include "isofront/exchange/OutputFile.h"

#include <algorithm>

namespace isofront::exchange {

core::Result<MeshFormat> meshFormatOf(const std::filesystem::path& path)
{
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    if (extension == ".glb")
        return MeshFormat::glb;
    if (extension == ".ply")
        return MeshFormat::ply;
    if (extension == ".obj")
        return MeshFormat::obj;
    if (extension == ".stl")
        return MeshFormat::stl;
    const std::string quoted = '"' + path.string() + '"';
    return core::failure(
        core::ErrorCode::usage,
        "can't tell the mesh format of " + quoted +
            "; let its name end in .glb, .ply, .obj or .stl");
}

std::string inOneLine(std::string text)
{
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\0'; }, ' ');
    return text;
}

core::Result<ExportReport> writeMesh(
    const surface::TriangleMesh& mesh,
    const std::filesystem::path& path,
    const ExportOptions& options)
{
    const core::Result<MeshFormat> format = meshFormatOf(path);
    if (!format)
        return tl::unexpected(format.error());
    const core::Result<MeshView> view = MeshView::of(mesh);
    if (!view)
        return tl::unexpected(view.error());
    core::Result<OutputFile> file = OutputFile::create(path);
    if (!file)
        return tl::unexpected(file.error());

    ExportReport report;
    if (view->isEmpty())
        report.warnings.emplace_back("the surface is empty, so the file holds no triangles; check "
                                     "the isovalue and the bounds");
    if (view->hasAttributes() && (*format == MeshFormat::obj || *format == MeshFormat::stl))
        report.warnings.emplace_back(
            "the format has no place for attributes, so they are left out; write .ply or .glb");
    if (view->hasNormals() && view->unusableNormals() > 0 && *format != MeshFormat::stl)
        report.warnings.emplace_back(
            std::to_string(view->unusableNormals()) +
            " normals have no direction and were written as (0, 0, 1)");

    const MeshJob job{*view, options, *file, report};
    core::Result<void> written;
    switch (*format) {
    case MeshFormat::glb:
        written = writeGlb(job);
        break;
    case MeshFormat::ply:
        written = writePly(job);
        break;
    case MeshFormat::obj:
        written = writeObj(job);
        break;
    case MeshFormat::stl:
        written = writeStl(job);
        break;
    }
    if (!written)
        return tl::unexpected(written.error().within(path.string()));
    const core::Result<std::uint64_t> bytes = file->commit();
    if (!bytes)
        return tl::unexpected(bytes.error());
    report.bytes = *bytes;
    return report;
}

} // namespace isofront::exchange
