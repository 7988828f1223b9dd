//! The document: sections in a list, each a list of blocks, written as Markdown.

use std::fs;

use vibrochain_maps::manifest::VERSION;

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Block {
    /// Markdown as it stands, a paragraph or a table.
    Prose(String),
    /// A picture beside the document.
    Picture {
        /// Its file name.
        file: String,
        /// What it shows, for readers who do not see it.
        caption: String,
    },
}

/// A heading and what stands below it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    pub(super) title: String,
    pub(super) blocks: Vec<Block>,
}

/// The whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Document {
    preface: String,
    pub(super) sections: Vec<Section>,
}

impl Document {
    /// A document with what holds for all sections: the machine, the version, how times were taken.
    pub(super) fn new(quick: bool) -> Self {
        let quick = if quick { "\n\nMade with `--quick`: few settings and short timings." } else { "" };
        let preface = format!(
            "Made by `studies accuracy --out DIR`, mapgen {VERSION}, on one thread of: {}.\n\n\
             Each method is set against a truth of its section at several settings. *time* is that of one evaluation: the \
             least mean of several batches, 20 ms or more in all, or of one call that takes 0.3 s or more. In the pictures the best place is at the lower left; \
             both axes are logarithmic, and errors of exactly 0 are drawn a decade below all others. Tables have each method at its last \
             setting, where it errs most.{quick}",
            processor()
        );
        Self { preface, sections: Vec::new() }
    }

    /// The Markdown text.
    pub(super) fn markdown(&self) -> String {
        let mut parts = vec!["# Error against run time".to_owned(), self.preface.clone()];
        for section in &self.sections {
            parts.push(format!("## {}", section.title));
            parts.extend(section.blocks.iter().map(|block| match block {
                Block::Prose(text) => text.trim_end().to_owned(),
                Block::Picture { file, caption } => format!("![{caption}]({file})"),
            }));
        }
        parts.join("\n\n") + "\n"
    }
}

/// The processor's name, where the system tells it.
fn processor() -> String {
    let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| "a processor without a name".to_owned(), |(_, name)| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_follow_the_preface_in_their_order() {
        let mut document = Document::new(true);
        for title in ["One", "Two"] {
            let picture = Block::Picture { file: format!("{title}.png"), caption: "errors".to_owned() };
            let blocks = vec![Block::Prose("Words.\n".to_owned()), picture];
            document.sections.push(Section { title: title.to_owned(), blocks });
        }
        let text = document.markdown();
        assert!(text.starts_with("# Error against run time\n\nMade by") && text.contains(VERSION));
        assert!(text.contains("--quick") && !Document::new(false).markdown().contains("--quick"));
        assert!(text.ends_with("\n\n## Two\n\nWords.\n\n![errors](Two.png)\n"));
    }
}
