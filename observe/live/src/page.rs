//! The page and its parts, as they were when this program was built.

/// A file of the page.
pub(crate) struct File {
    pub(crate) path: &'static str,
    pub(crate) kind: &'static str,
    pub(crate) text: &'static str,
}

pub(crate) const INDEX: File = html("/", include_str!("../page/index.html"));

/// What the page consists of. These hold nothing of the swarm: they are served without a token.
pub(crate) const PARTS: [File; 13] = [
    File { path: "/style.css", kind: "text/css; charset=utf-8", text: include_str!("../page/style.css") },
    script("/app/main.js", include_str!("../page/app/main.js")),
    script("/app/camera.js", include_str!("../page/app/camera.js")),
    script("/app/connection.js", include_str!("../page/app/connection.js")),
    script("/app/controls.js", include_str!("../page/app/controls.js")),
    script("/app/explored.js", include_str!("../page/app/explored.js")),
    script("/app/layer.js", include_str!("../page/app/layer.js")),
    script("/app/panel.js", include_str!("../page/app/panel.js")),
    script("/app/place.js", include_str!("../page/app/place.js")),
    script("/app/robots.js", include_str!("../page/app/robots.js")),
    script("/app/swarm.js", include_str!("../page/app/swarm.js")),
    script("/app/theme.js", include_str!("../page/app/theme.js")),
    script("/app/words.js", include_str!("../page/app/words.js")),
];

const fn html(path: &'static str, text: &'static str) -> File {
    File { path, kind: "text/html; charset=utf-8", text }
}

const fn script(path: &'static str, text: &'static str) -> File {
    File { path, kind: "text/javascript; charset=utf-8", text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_script_that_is_imported_is_served() {
        for part in PARTS.iter().chain([&INDEX]) {
            let named = part.text.split(['"', '\'']).filter(|word| word.ends_with(".js"));
            for name in named {
                let path = name.replace("./", "/app/");
                assert!(PARTS.iter().any(|part| part.path == path), "{} imports {name}", part.path);
            }
        }
    }

    #[test]
    fn the_page_names_no_other_host_and_stays_within_lines_and_columns() {
        for part in PARTS.iter().chain([&INDEX]) {
            let elsewhere = part.text.replace("http://www.w3.org/2000/svg", "");
            assert!(!elsewhere.contains("://") || part.path == "/app/connection.js", "{} names a host", part.path);
            assert!(part.text.lines().count() <= 800, "{} is long", part.path);
            let wide = part.text.lines().position(|line| line.chars().count() > 120);
            assert_eq!(wide, None, "{} has a wide line", part.path);
        }
    }
}
