//! A tunnel by `ssh -L`, as docs/viewer.md shows it, to a real sshd with keys and settings of its own.

use super::net::{Net, Running};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PORT: u16 = 2222;

/// The viewer's port, there and here.
const VIEWER_PORT: u16 = 8080;

/// A viewer at the other end of a tunnel.
pub(super) struct Tunnel {
    _ssh: Running,
    _sshd: Running,
}

impl Tunnel {
    /// Starts sshd there, and over it `program view`; with the address that this prints.
    pub(super) fn open(net: &Net, folder: &Path, program: &Path, flags: &[&str]) -> Result<(Tunnel, String)> {
        let file = |name: &str| folder.join(name).display().to_string();
        for name in ["host", "user"] {
            let status = Command::new("ssh-keygen")
                .args(["-q", "-t", "ed25519", "-N", "", "-f", &file(name)])
                .status()
                .context("cannot run ssh-keygen")?;
            ensure!(status.success(), "ssh-keygen failed");
        }
        fs::copy(file("user.pub"), file("authorized"))?;
        let key = fs::read_to_string(file("host.pub"))?;
        fs::write(file("known"), format!("[{}]:{PORT} {key}", net.address))?;
        // Where sshd separates its privileges; packages make it at the start of the system.
        fs::create_dir_all("/run/sshd")?;
        let settings = [
            format!("HostKey {}", file("host")),
            format!("AuthorizedKeysFile {}", file("authorized")),
            format!("ListenAddress {}:{PORT}", net.address),
            // Without PAM a root without password is locked out, keys or not.
            "UsePAM yes\nStrictModes no\nPermitRootLogin prohibit-password\nPidFile none\n".to_owned(),
            // Where this process was killed, the other end is silent, not closed.
            "ClientAliveInterval 1\nClientAliveCountMax 3\n".to_owned(),
        ];
        fs::write(file("settings"), settings.join("\n"))?;
        let mut sshd = net.server.command("/usr/sbin/sshd");
        sshd.args(["-D", "-f", &file("settings"), "-E", &file("log")]).stdin(Stdio::null());
        let sshd = Running(sshd.spawn().context("cannot start sshd")?);
        let start = Instant::now();
        while !fs::read_to_string(file("log")).unwrap_or_default().contains("Server listening") {
            ensure!(start.elapsed() < Duration::from_secs(5), "sshd does not listen: see {}", file("log"));
            std::thread::sleep(Duration::from_millis(10));
        }
        let mut ssh = net.page.command("ssh");
        // With a terminal: what runs there is told when the connection ends.
        ssh.args(["-tt", "-F", "none", "-i", &file("user"), "-p", &PORT.to_string()])
            .args(["-o", &format!("UserKnownHostsFile={}", file("known")), "-o", "BatchMode=yes"])
            .args(["-L", &format!("{VIEWER_PORT}:127.0.0.1:{VIEWER_PORT}"), &format!("root@{}", net.address)])
            .arg(format!("HOME={} {}", folder.display(), program.display()))
            .args(["view", "--no-open", "--port", &VIEWER_PORT.to_string()])
            .args(flags)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut ssh = Running(ssh.spawn().context("cannot start ssh")?);
        let lines = BufReader::new(ssh.0.stdout.take().context("no output")?).lines();
        // A terminal shows what goes to standard error, too.
        let url = lines.map_while(|line| line.ok()).find(|line| line.starts_with("http://127.0.0.1:"));
        let url = url.with_context(|| format!("no viewer over ssh: see {}", file("log")))?;
        Ok((Tunnel { _ssh: ssh, _sshd: sshd }, url))
    }
}
