//! Where frames are to be shown.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use re_sdk::external::re_uri::ProxyUri;

use crate::Error;

/// Where frames are to be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// In a viewer that is started, unless one runs already.
    Spawn,
    /// In the viewer that listens at this address.
    Address(ProxyUri),
    /// Later: in a file.
    File(PathBuf),
}

impl Target {
    /// The viewer of this machine that listens at `port`.
    pub(super) fn local(port: u16) -> Result<Self, Error> {
        format!("127.0.0.1:{port}").parse()
    }
}

impl FromStr for Target {
    type Err = Error;

    /// `spawn`, the name of a file that ends in `.rrd`, `host:port` or the address as viewers print it.
    fn from_str(text: &str) -> Result<Self, Error> {
        if text == "spawn" {
            return Ok(Self::Spawn);
        }
        if !text.contains("://") && text.to_ascii_lowercase().ends_with(".rrd") {
            return Ok(Self::File(text.into()));
        }
        let short = text.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
        let uri = if short && !text.contains('/') { format!("rerun+http://{text}/proxy") } else { text.to_owned() };
        uri.parse().map(Self::Address).map_err(|_| {
            let text = format!(
                "{text} is neither spawn, nor a viewer's address (127.0.0.1:9876, or \
                 rerun+http://127.0.0.1:9876/proxy), nor a file that ends in .rrd"
            );
            Error::Usage(text)
        })
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spawn => f.write_str("spawn"),
            Self::Address(uri) => uri.fmt(f),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_told_from_each_other() {
        let parsed = |text: &str| text.parse::<Target>().map(|target| target.to_string()).map_err(|e| e.is_usage());
        assert_eq!("spawn".parse::<Target>().unwrap(), Target::Spawn);
        assert_eq!("a:1/b.rrd".parse::<Target>().unwrap(), Target::File("a:1/b.rrd".into()));
        let local = "rerun+http://127.0.0.1:9876/proxy";
        assert_eq!(parsed("127.0.0.1:9876"), Ok(local.to_owned()));
        assert_eq!(parsed(local), Ok(local.to_owned()));
        assert_eq!(parsed("[::1]:9876"), Ok("rerun+http://[::1]:9876/proxy".to_owned()));
        for wrong in ["", "shown", "host", "host:", ":9876", "host:70000", "http//x:1", "rerun+http://h:1/catalog"] {
            assert_eq!(parsed(wrong), Err(true), "{wrong}");
        }
    }
}
