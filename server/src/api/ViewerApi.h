#pragma once

#include "Route.h"

#include <isofront/core/Result.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace isofront::server {

/// The files of the web client, as they are sent. All are read before the first is asked for, so
/// that no request leads into a file system: what isn't there by name doesn't exist.
///
/// Thread: immutable.
class ViewerFiles {
public:
    struct File {
        std::string mediaType;
        std::shared_ptr<const std::string> plain;
        std::string plainTag; ///< strong entity tags
        /// For clients that take gzip; null where it would hardly be shorter.
        std::shared_ptr<const std::string> packed;
        std::string packedTag;
    };

    /// Without any: the service says how the client is built.
    ViewerFiles() = default;
    /// Reads `index.html` and what lies beside it and in `assets`, as Vite builds them.
    /// Errors: inputOutput if there is no page, or a file can't be read; resourceLimit for more
    /// than 64 MiB.
    static core::Result<ViewerFiles> read(const std::filesystem::path& folder);

    [[nodiscard]] bool isEmpty() const { return _files.empty(); }
    /// @param path  "index.html", "assets/index-B1gq.js"; null if there is no such file
    [[nodiscard]] const File* find(const std::string& path) const;
    [[nodiscard]] const std::map<std::string, File>& all() const { return _files; }

private:
    std::map<std::string, File> _files;
};

/// The page at `/`, and what it needs. Needs no token: whoever has none is asked by the page.
Api viewerApi(ViewerFiles files);

} // namespace isofront::server
